//! Which stacks of films were met, how often, and by how much of the light.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::optics::batch::Film;

/// Stacks by the sequence of their media.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stacks {
    known: BTreeMap<Vec<u16>, Met>,
    key: Vec<u16>,
}

/// All stacks of one sequence of media.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Met {
    /// How often.
    pub hits: u64,
    /// Power that met them, in units of the power of a tree.
    pub power: f64,
    /// Least and greatest thickness of each layer, µm.
    pub thickness: Vec<(f64, f64)>,
}

/// Different sequences of media counted.
const MOST_COUNTED: usize = 1 << 10;

impl Stacks {
    /// Counts a stack that light of some power has met.
    pub(super) fn add(&mut self, layers: &[Film], power: f64) {
        self.key.clear();
        self.key.extend(layers.iter().map(|l| l.medium as u16));
        if let Some(met) = self.known.get_mut(&self.key) {
            met.hits += 1;
            met.power += power;
            for ((least, most), layer) in met.thickness.iter_mut().zip(layers) {
                (*least, *most) = (least.min(layer.thickness), most.max(layer.thickness));
            }
        } else if self.known.len() < MOST_COUNTED {
            let thickness = layers.iter().map(|l| (l.thickness, l.thickness)).collect();
            self.known.insert(self.key.clone(), Met { hits: 1, power, thickness });
        }
    }

    /// Adds what others met.
    pub fn merge(&mut self, other: &Self) {
        for (media, met) in &other.known {
            match self.known.get_mut(media) {
                Some(sum) => sum.add(met),
                None => {
                    self.known.insert(media.clone(), met.clone());
                }
            }
        }
    }

    /// Sequences of media with what was met of each.
    pub fn iter(&self) -> impl Iterator<Item = (&[u16], &Met)> {
        self.known.iter().map(|(media, met)| (&media[..], met))
    }

    /// Thickness of the thinnest layer, µm; infinite without any.
    pub fn thinnest(&self) -> f64 {
        self.known.values().flat_map(|met| &met.thickness).fold(f64::INFINITY, |least, t| least.min(t.0))
    }
}

impl Met {
    fn add(&mut self, other: &Self) {
        self.hits += other.hits;
        self.power += other.power;
        for (sum, t) in self.thickness.iter_mut().zip(&other.thickness) {
            *sum = (sum.0.min(t.0), sum.1.max(t.1));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_is_the_sum_of_its_parts() {
        let stack = |media: &[usize], thickness: f64| -> Vec<Film> {
            media.iter().map(|&medium| Film { medium, thickness }).collect()
        };
        let (mut a, mut b, mut whole) = (Stacks::default(), Stacks::default(), Stacks::default());
        for (i, media) in [&[1, 2][..], &[2, 1], &[1, 2], &[3]].iter().enumerate() {
            let layers = stack(media, 0.1 * (i + 1) as f64);
            if i < 2 {
                a.add(&layers, 0.5)
            } else {
                b.add(&layers, 0.25)
            }
            whole.add(&layers, if i < 2 { 0.5 } else { 0.25 });
        }
        a.merge(&b);
        assert!(a.iter().eq(whole.iter()));
        let met = a.iter().find(|(media, _)| media == &[1, 2]).unwrap().1;
        assert_eq!((met.hits, met.power, met.thickness[0]), (2, 0.75, (0.1, 0.1 * 3.0)));
        assert_eq!(a.thinnest(), 0.1);
    }
}
