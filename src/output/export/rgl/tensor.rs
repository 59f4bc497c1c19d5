//! The container of Mitsuba's tensor files, little endian: the magic and version 1.0, the number of fields; for each its name
//! (length first), number of dimensions, type, place in the file and shape; then their values, each at a multiple of 8 bytes.

const MAGIC: &[u8] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
const ALIGNMENT: usize = 8;

/// Values of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Type 1.
    U8(Vec<u8>),
    /// Type 3.
    U16(Vec<u16>),
    /// Type 10.
    F32(Vec<f32>),
}

/// A named array, its last index fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// As many as the product of `shape`.
    pub values: Values,
}

impl Field {
    /// Of numbers.
    pub fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        Self { name, shape: shape.to_vec(), values: Values::F32(values) }
    }

    /// Of bytes.
    pub fn bytes(name: &'static str, values: &[u8]) -> Self {
        Self { name, shape: vec![values.len()], values: Values::U8(values.to_vec()) }
    }
}

impl Values {
    fn dtype(&self) -> u8 {
        match self {
            Self::U8(_) => 1,
            Self::U16(_) => 3,
            Self::F32(_) => 10,
        }
    }

    fn to_le_bytes(&self) -> Vec<u8> {
        match self {
            Self::U8(all) => all.clone(),
            Self::U16(all) => all.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Self::F32(all) => all.iter().flat_map(|x| x.to_le_bytes()).collect(),
        }
    }
}

/// The file.
pub fn to_bytes(fields: &[Field]) -> Vec<u8> {
    let head =
        |f: &Field| size_of::<u16>() + f.name.len() + size_of::<u16>() + 1 + size_of::<u64>() * (1 + f.shape.len());
    let start: usize = MAGIC.len() + VERSION.len() + size_of::<u32>() + fields.iter().map(head).sum::<usize>();
    let mut out = [MAGIC, &VERSION, &(fields.len() as u32).to_le_bytes()].concat();
    let mut data = Vec::new();
    let pad = |data: &mut Vec<u8>| data.resize((start + data.len()).next_multiple_of(ALIGNMENT) - start, 0);
    for f in fields {
        pad(&mut data);
        out.extend((f.name.len() as u16).to_le_bytes());
        out.extend(f.name.as_bytes());
        out.extend((f.shape.len() as u16).to_le_bytes());
        out.push(f.values.dtype());
        out.extend(((start + data.len()) as u64).to_le_bytes());
        f.shape.iter().for_each(|&n| out.extend((n as u64).to_le_bytes()));
        data.extend(f.values.to_le_bytes());
    }
    out.extend(data);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_where_the_header_says() {
        let fields = [Field::bytes("a", b"xyz"), Field::floats("bc", &[1, 2], vec![1.5, -2.0])];
        let bytes = to_bytes(&fields);
        assert_eq!(&bytes[..18], b"tensor_file\0\x01\0\x02\0\0\0");
        let first = &bytes[18..];
        assert_eq!(&first[..6], [1, 0, b'a', 1, 0, 1]);
        let at = |from: usize| u64::from_le_bytes(bytes[from..from + 8].try_into().unwrap()) as usize;
        let (a, shape) = (at(24), at(32));
        assert_eq!((&bytes[a..a + shape], a % 8), (&b"xyz"[..], 0));
        assert_eq!(&bytes[40..47], [2, 0, b'b', b'c', 2, 0, 10]);
        let b = at(47);
        assert_eq!((at(55), at(63), b % 8, bytes.len()), (1, 2, 0, b + 8));
        assert_eq!(&bytes[b..], [1.5f32.to_le_bytes(), (-2.0f32).to_le_bytes()].concat());
    }
}
