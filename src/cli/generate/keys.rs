//! The parameters of each kind, as options: names, defaults, units. What they may be, the reader of the sample file
//! knows.

use std::marker::PhantomData;
use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command, Error, FromArgMatches};

/// A parameter.
pub struct Key {
    /// Its name as an option; in the sample file hyphens are underscores.
    pub name: &'static str,
    /// What it is if it is not given; without a default it is left out.
    pub default: Option<&'static str>,
    /// What stands for its value in the help.
    pub value: &'static str,
    /// What it means.
    pub help: &'static str,
    /// How it is written in the sample file.
    pub form: Form,
}

/// How a parameter is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A number, a list of them, or a text.
    Value,
    /// The name of a medium, with its index or file if it is not built in: `NAME` or `NAME=INDEX`.
    Medium,
    /// The index of the medium of this name.
    Index(&'static str),
    /// A file, which the sample file names from wherever it is.
    File,
}

/// A kind of generated samples.
pub trait Kind {
    /// Its name in the sample file.
    const NAME: &'static str;
    /// What the sample file says of it: a rule, unless it is an object.
    const TABLE: (&'static str, &'static str) = ("generate", "kind");
    /// Its parameters.
    const KEYS: &'static [&'static [Key]];
}

/// What was given for a kind, and what to write.
#[derive(Debug)]
pub struct Given<K> {
    /// Keys with their values as they were typed, or by default.
    pub values: Vec<(&'static Key, String)>,
    /// The file to write.
    pub output: PathBuf,
    /// Whether the sample ends beside its patch.
    pub open: bool,
    /// Objects instead of a table.
    pub explode: bool,
    /// Sides of the prism for a cylinder.
    pub fineness: u32,
    /// Whether meshes keep the volume.
    pub same_volume: bool,
    kind: PhantomData<K>,
}

impl std::fmt::Debug for Key {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl<K: Kind> clap::Args for Given<K> {
    fn augment_args(command: Command) -> Command {
        let output = Arg::new("output").short('o').long("output").value_name("FILE").required(true).help(
            "The file to write: FILE.toml is a sample file, FILE.obj a mesh in µm with its materials in an .mtl file beside it",
        );
        let command = K::KEYS.iter().flat_map(|keys| *keys).fold(command.arg(output), |command, key| {
            let arg = Arg::new(key.name).long(key.name).value_name(key.value).help(key.help).allow_hyphen_values(true);
            command.arg(key.default.map_or(arg.clone(), |d| arg.default_value(d)))
        });
        let flag = |name: &'static str| Arg::new(name).long(name).action(ArgAction::SetTrue);
        command
            .arg(flag("open").help("The sample ends beside its patch instead of repeating for ever"))
            .arg(flag("explode").help("In a sample file, every body by itself instead of the rule that makes them"))
            .arg(
                Arg::new("fineness")
                    .long("fineness")
                    .value_name("N")
                    .default_value("24")
                    .value_parser(clap::value_parser!(u32).range(3..=1000))
                    .help("In a mesh, sides of the prism for a cylinder; a sphere has 20 * 4^k faces, k nearest to log2(N/5)"),
            )
            .arg(flag("same-volume").help(
                "In a mesh, spheres and cylinders keep their volume; else their corners lie on the surface, and bodies \
                 that touch do not overlap",
            ))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<K: Kind> FromArgMatches for Given<K> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let text = |name: &str| matches.get_one::<String>(name).cloned();
        let keys = K::KEYS.iter().flat_map(|keys| *keys);
        Ok(Self {
            values: keys.filter_map(|key| Some((key, text(key.name)?))).collect(),
            output: text("output").unwrap_or_default().into(),
            open: matches.get_flag("open"),
            explode: matches.get_flag("explode"),
            fineness: matches.get_one("fineness").copied().unwrap_or(24),
            same_volume: matches.get_flag("same-volume"),
            kind: PhantomData,
        })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

const fn key(name: &'static str, default: Option<&'static str>, value: &'static str, help: &'static str) -> Key {
    Key { name, default, value, help, form: Form::Value }
}

const fn medium(name: &'static str, default: Option<&'static str>, help: &'static str) -> Key {
    Key { name, default, value: "NAME[=INDEX]", help, form: Form::Medium }
}

const COMMON: &[Key] = &[
    key("seed", Some("1"), "N", "Seed: the same one gives the same sample"),
    key("bottom", Some("0"), "LENGTH", "Height of the lower face, µm or with its unit"),
    key("priority", Some("0"), "N", "Where bodies overlap those of higher priority win"),
];

/// Interlocking bricks with cores: the platelets of a hummingbird's feather
#[derive(Debug)]
pub struct Bricks;

impl Kind for Bricks {
    const NAME: &'static str = "bricks";
    const KEYS: &'static [&'static [Key]] = &[&[
        key("layers", Some("7"), "N", "Number of layers"),
        key("count", Some("4,3"), "NX,NY", "Bricks along x and y in a patch"),
        key("size", Some("1500nm,2000nm,172nm"), "X,Y,Z", "Edge lengths of a brick, µm or with their unit"),
        key("shell", Some("37nm,37nm,37nm"), "X,Y,Z", "Thickness of the shell around the core"),
        key("shift", Some("0.5,0"), "X,Y", "By which parts of a brick every other layer is shifted"),
        Key {
            name: "index",
            default: Some("2.0"),
            value: "N",
            help: "Refractive index of the shell",
            form: Form::Index("platelet"),
        },
        Key {
            name: "core-index",
            default: Some("1.5"),
            value: "N",
            help: "Refractive index of the core",
            form: Form::Index("core"),
        },
    ]];
}

/// The fibre web of a sheet of paper
#[derive(Debug)]
pub struct Web;

impl Kind for Web {
    const NAME: &'static str = "web";
    const KEYS: &'static [&'static [Key]] = &[
        &[
            key("layers", Some("10"), "N", "Number of layers"),
            key("fibres", Some("10"), "N", "Fibres per layer; a web that is not oriented has LAYERS * FIBRES in all"),
            key(
                "length",
                None,
                "LENGTH",
                "Length of a fibre [default: 2 mm; of a periodic oriented web that of the patch]",
            ),
            key("radius", Some("10um"), "LENGTH", "Half the width of a fibre, µm or with its unit"),
            key(
                "inner-radius",
                None,
                "LENGTH",
                "Half the width of its hollow, 0 for none [default: half of the radius]",
            ),
            key("flatten", Some("1"), "RATIO", "Thickness over width, above 0 to 1"),
            key(
                "deviation",
                Some("0"),
                "DEGREES",
                "Mean angle to x without its sign (normal, cut off at 90 degrees), 0 to 44, or `random`. With 0 fibres lie \
                 side by side in layers; else each sinks at a random place until it touches another",
            ),
            key(
                "size",
                None,
                "W,D",
                "Edge lengths of the patch [required unless oriented: then LENGTH and the fibres side by side]",
            ),
            medium("medium", Some("fibre=1.53"), "Medium of the walls, with its index or file unless it is built in"),
            medium("inner-medium", Some("air"), "Medium of the hollow"),
        ],
        COMMON,
    ];
}

/// Spheres at random places in a slab, none overlapping
#[derive(Debug)]
pub struct Packing;

impl Kind for Packing {
    const NAME: &'static str = "packing";
    const KEYS: &'static [&'static [Key]] = &[
        &[
            key("radius", None, "LENGTH", "Mean radius, µm or with its unit; or give --radii"),
            key(
                "spread",
                None,
                "RATIO",
                "Standard deviation of the radius over its mean: log-normal, cut off at 3 deviations of the logarithm [default: 0, all alike]",
            ),
            key("radii", None, "R1,R2,...", "Some radii instead, each with its share"),
            key("shares", None, "S1,S2,...", "Shares of --radii in the number of spheres; their sum is 1"),
            key("count", None, "N", "Number of spheres; or give --fraction"),
            key("fraction", None, "SHARE", "Their share of the volume of the slab, 0 to about 0.38"),
            key("size", None, "W,D,H", "Edge lengths of the slab, µm or with their unit [required]"),
            medium("medium", Some("pigment=1.59"), "Medium, with its index or file unless it is built in"),
        ],
        COMMON,
    ];
}

/// Flakes of an effect pigment at random places in a slab: thin prisms with a skin all round
#[derive(Debug)]
pub struct Flakes;

impl Kind for Flakes {
    const NAME: &'static str = "flakes";
    const KEYS: &'static [&'static [Key]] = &[
        &[
            key(
                "diameter",
                Some("20um"),
                "LENGTH",
                "Mean diameter of the circle through the corners, without the skin",
            ),
            key(
                "spread",
                Some("0"),
                "RATIO",
                "Standard deviation of the diameter over its mean: log-normal, cut off at 3 deviations of the logarithm",
            ),
            key("sides", Some("6"), "N", "Corners of a flake, 3 to 64"),
            key("thickness", Some("400nm"), "LENGTH", "Thickness without the skin"),
            key("coating", Some("60nm"), "LENGTH", "Thickness of the skin"),
            key("tilt", Some("0"), "DEGREES", "Mean angle out of the plane (Rayleigh), 0 to 20, or `random`"),
            key("count", None, "N", "Number of flakes; or give --fraction"),
            key("fraction", None, "SHARE", "Their share of the volume of the slab"),
            key("size", None, "W,D,H", "Edge lengths of the slab, µm or with their unit [required]"),
            medium("medium", Some("titania=2.5"), "Medium of the skin, with its index or file unless it is built in"),
            medium("core", Some("mica=1.58"), "Medium under the skin"),
        ],
        COMMON,
    ];
}

/// A random rough surface: Gaussian heights of Gaussian autocorrelation
#[derive(Debug)]
pub struct Rough;

impl Kind for Rough {
    const NAME: &'static str = "rough";
    const KEYS: &'static [&'static [Key]] = &[&[
        key("rms", Some("100nm"), "LENGTH", "Standard deviation of the heights, µm or with its unit"),
        key("length", Some("2um"), "LENGTH", "Distance at which the correlation of heights has fallen to 1/e"),
        key("size", Some("40um,40um"), "W,D", "Edge lengths of the patch, at least eight times the length"),
        key("points", Some("256"), "N|NX,NY", "Heights along x and y, at least two in each length"),
        key("base", Some("0"), "LENGTH", "Mean height"),
        key(
            "bottom",
            None,
            "LENGTH",
            "Depth of the floor below the lowest height [default: the range of heights, or 1 µm]",
        ),
        key("seed", Some("1"), "N", "Seed: the same one gives the same sample"),
        key("priority", Some("0"), "N", "Where bodies overlap those of higher priority win"),
        medium("medium", Some("glass=1.5"), "Medium below the surface, with its index or file unless it is built in"),
    ]];
}

/// Measured heights: Gwyddion .gsf, ISO 25178 .sdf, ESRI .asc, grey PNG and TIFF
#[derive(Debug)]
pub struct HeightField;

impl Kind for HeightField {
    const NAME: &'static str = "height_field";
    const TABLE: (&'static str, &'static str) = ("object", "shape");
    const KEYS: &'static [&'static [Key]] = &[&[
        Key {
            name: "file",
            default: None,
            value: "FILE",
            help: "The heights: .gsf, .sdf, .asc, .png or .tif [required]",
            form: Form::File,
        },
        key("pixel", None, "LENGTH|X,Y", "Distance of neighbouring heights [required for pictures]"),
        key("height", None, "Z|LOW,HIGH", "Height of white over black, or heights of both [required for pictures]"),
        key("scale-z", None, "FACTOR", "By what the heights are multiplied"),
        key("fill", None, "LENGTH", "Height where none was measured"),
        key("base", None, "LENGTH", "Height of what the file calls 0"),
        key(
            "bottom",
            None,
            "LENGTH",
            "Depth of the floor below the lowest height [default: the range of heights, or 1 µm]",
        ),
        medium("medium", Some("glass=1.5"), "Medium below the surface, with its index or file unless it is built in"),
    ]];
}

/// Layers of unequal flat platelets with gaps, each layer laid by itself
#[derive(Debug)]
pub struct Mosaic;

impl Kind for Mosaic {
    const NAME: &'static str = "mosaic";
    const KEYS: &'static [&'static [Key]] = &[
        &[
            key("layers", Some("7"), "N", "Number of layers"),
            key("count", Some("4,3"), "NX,NY", "Platelets in a row along x, and rows, in a patch"),
            key("size", Some("1500nm,1000nm,100nm"), "X,Y,Z", "Mean edge lengths of a platelet, and its thickness"),
            key(
                "spread",
                Some("0.2"),
                "RATIO",
                "Standard deviation of the edges along x and y over their mean (log-normal)",
            ),
            key("gap", Some("50nm"), "LENGTH", "Distance of neighbours in a layer"),
            key("spacing", Some("100nm"), "LENGTH", "Distance of layers"),
            key("shell", None, "LENGTH", "Thickness of the shell around a core, if there are cores"),
            medium("medium", Some("keratin"), "Medium, with its index or file unless it is built in"),
            medium("core", None, "Medium of the cores, such as air or melanin"),
        ],
        COMMON,
    ];
}
