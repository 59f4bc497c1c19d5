//! Draws the pictures of docs/conventions.md: `cargo run --example conventions`
//!
//! Directions come from the program itself, so that the pictures cannot say anything else than it does.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use gonio_embree::dome::Facet;
use gonio_embree::light::Incidence;

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs");

const INK: &str = "#222222";
const FAINT: &str = "#9aa0a6";
const IN: &str = "#c2410c";
const OUT: &str = "#1d4ed8";
const THROUGH: &str = "#047857";
const S: &str = "#7c3aed";

fn main() -> std::io::Result<()> {
    for (name, picture) in [("angles", angles()), ("scan", scan()), ("polarization", polarization()), ("dome", dome())]
    {
        std::fs::write(format!("{FOLDER}/conventions-{name}.svg"), picture.finish())?;
    }
    Ok(())
}

/// A picture in the making, in pixels, y down.
struct Picture {
    size: [u32; 2],
    text: String,
}

impl Picture {
    fn new(width: u32, height: u32) -> Self {
        Self { size: [width, height], text: String::new() }
    }

    fn finish(self) -> String {
        let [w, h] = self.size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"sans-serif\" font-size=\"16\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"white\"/>\n{}</svg>\n",
            self.text
        )
    }

    fn path(&mut self, points: &[DVec2], closed: bool, style: &str) {
        let places: Vec<String> = points.iter().map(|p| format!("{:.1} {:.1}", p.x, p.y)).collect();
        let end = if closed { " Z" } else { "" };
        let _ = writeln!(self.text, "<path d=\"M {}{end}\" {style}/>", places.join(" L "));
    }

    fn line(&mut self, a: DVec2, b: DVec2, colour: &str, width: f64) {
        self.path(&[a, b], false, &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\""));
    }

    fn dashed(&mut self, points: &[DVec2]) {
        let style = format!("fill=\"none\" stroke=\"{FAINT}\" stroke-width=\"1.2\" stroke-dasharray=\"5 4\"");
        self.path(points, false, &style);
    }

    /// A line with a head at `b`.
    fn arrow(&mut self, a: DVec2, b: DVec2, colour: &str, width: f64) {
        let along = (b - a).normalize();
        let (neck, across) = (b - along * 12.0, along.perp() * 5.0);
        self.line(a, b - along * 8.0, colour, width);
        self.path(&[b, neck + across, neck - across], true, &format!("fill=\"{colour}\""));
    }

    fn arc(&mut self, points: &[DVec2], colour: &str) {
        self.path(points, false, &format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\""));
    }

    /// Text whose middle is at a place.
    fn label(&mut self, at: DVec2, colour: &str, text: &str) {
        let (x, y) = (at.x, at.y + 5.5);
        let _ = writeln!(
            self.text,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\" text-anchor=\"middle\">{text}</text>"
        );
    }

    /// Text that begins at a place.
    fn note(&mut self, at: DVec2, colour: &str, text: &str) {
        let (x, y) = (at.x, at.y + 5.5);
        let _ = writeln!(self.text, "<text x=\"{x:.1}\" y=\"{y:.1}\" fill=\"{colour}\">{text}</text>");
    }

    /// An arrow that points out of the page.
    fn towards_us(&mut self, at: DVec2, colour: &str) {
        let _ = writeln!(
            self.text,
            "<circle cx=\"{0:.1}\" cy=\"{1:.1}\" r=\"7\" fill=\"white\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <circle cx=\"{0:.1}\" cy=\"{1:.1}\" r=\"2.5\" fill=\"{colour}\"/>",
            at.x, at.y
        );
    }
}

/// A parallel view of the sample's frame.
struct View {
    origin: DVec2,
    scale: f64,
    right: DVec3,
    up: DVec3,
}

impl View {
    /// From azimuth `from_deg`, `height_deg` above the sample.
    fn new(origin: DVec2, scale: f64, from_deg: f64, height_deg: f64) -> Self {
        let ((sin, cos), (sin_h, cos_h)) = (from_deg.to_radians().sin_cos(), height_deg.to_radians().sin_cos());
        let right = DVec3::new(-sin, cos, 0.0);
        Self { origin, scale, right, up: DVec3::new(-sin_h * cos, -sin_h * sin, cos_h) }
    }

    fn at(&self, p: DVec3) -> DVec2 {
        self.origin + self.scale * DVec2::new(p.dot(self.right), -p.dot(self.up))
    }

    fn towards_us(&self, p: DVec3) -> bool {
        self.right.cross(self.up).dot(p) > 0.0
    }

    /// The shorter way from one direction to another.
    fn between(&self, a: DVec3, b: DVec3, radius: f64) -> Vec<DVec2> {
        let (angle, across) = (a.angle_between(b), (b - a * a.dot(b)).normalize());
        (0..=40)
            .map(|i| angle * f64::from(i) / 40.0)
            .map(|t| self.at(radius * (a * t.cos() + across * t.sin())))
            .collect()
    }

    /// Part of a circle in the plane of the sample.
    fn around(&self, from_deg: f64, to_deg: f64, radius: f64) -> Vec<DVec2> {
        let angle = |i: u32| (from_deg + (to_deg - from_deg) * f64::from(i) / 60.0).to_radians();
        (0..=60).map(|i| self.at(radius * DVec3::new(angle(i).cos(), angle(i).sin(), 0.0))).collect()
    }
}

/// Direction at polar angle and azimuth.
fn direction(theta_deg: f64, phi_deg: f64) -> DVec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta_deg.to_radians().sin_cos(), phi_deg.to_radians().sin_cos());
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// Polar angles and azimuths of the incidence and of two exits.
fn angles() -> Picture {
    let mut picture = Picture::new(860, 550);
    let view = View::new(DVec2::new(430.0, 300.0), 225.0, -62.0, 22.0);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| view.at(DVec3::new(x, y, 0.0)));
    picture.path(&corners, true, &format!("fill=\"#f1f5f9\" stroke=\"{FAINT}\""));
    for (end, name) in [(DVec3::X * 1.3, "x"), (DVec3::Y * 1.4, "y"), (DVec3::Z * 1.2, "z, out of the sample")] {
        picture.arrow(view.at(DVec3::ZERO), view.at(end), INK, 1.5);
        let side = if end.z > 0.0 { DVec2::new(88.0, 4.0) } else { DVec2::new(10.0, -12.0) };
        picture.label(view.at(end) + side, INK, name);
    }
    let incidence = Incidence { theta_deg: 58.0, phi_deg: 25.0 };
    let source = -incidence.propagation();
    ray(
        &mut picture,
        &view,
        source,
        &Told { angles: [58.0, 25.0], radii: [0.45, 0.48], at: 12.0, colour: IN, index: "ᵢ" },
    );
    let back = Told { angles: [35.0, 250.0], radii: [0.6, 0.66], at: 48.0, colour: OUT, index: "ₒ" };
    ray(&mut picture, &view, direction(35.0, 250.0), &back);
    let through = Told { angles: [145.0, 160.0], radii: [0.95, 0.3], at: 103.0, colour: THROUGH, index: "ₒ" };
    ray(&mut picture, &view, direction(145.0, 160.0), &through);
    picture.label(view.at(source * 1.04) + DVec2::new(20.0, -8.0), IN, "light");
    let notes = [
        (24.0, IN, "incidence θᵢ, φᵢ: the direction towards the source (θᵢ &lt; 90°)"),
        (48.0, OUT, "exit θₒ, φₒ, reflected: where the light goes (θₒ &lt; 90°)"),
        (72.0, THROUGH, "exit θₒ, φₒ, transmitted (θₒ &gt; 90°)"),
    ];
    notes.iter().for_each(|&(y, colour, text)| picture.note(DVec2::new(20.0, y + 452.0), colour, text));
    picture
}

/// How a direction is told.
struct Told {
    /// θ and φ, degrees.
    angles: [f64; 2],
    /// How far out their arcs are drawn.
    radii: [f64; 2],
    /// Azimuth of the name of φ.
    at: f64,
    colour: &'static str,
    index: &'static str,
}

/// A direction with its angles. Arrows go as the light goes.
fn ray(picture: &mut Picture, view: &View, d: DVec3, told: &Told) {
    let ([theta, phi], [r_theta, r_phi], colour) = (told.angles, told.radii, told.colour);
    let (origin, foot) = (view.at(DVec3::ZERO), d.with_z(0.0));
    picture.dashed(&[view.at(d), view.at(foot), origin]);
    picture.arc(&view.around(0.0, phi, r_phi), colour);
    picture.arc(&view.between(DVec3::Z, d, r_theta), colour);
    if told.index == "ᵢ" {
        picture.arrow(view.at(d), view.at(d * 0.06), colour, 3.0);
    } else {
        picture.arrow(origin, view.at(d), colour, 3.0);
    }
    picture.label(view.at(direction(theta * 0.55, phi) * (r_theta + 0.11)), colour, &format!("θ{}", told.index));
    picture.label(view.at(direction(90.0, told.at) * (r_phi + 0.1)), colour, &format!("φ{}", told.index));
}

/// The plane of incidence, seen so that +x is on the left: the light comes from there.
fn plane(origin: DVec2, scale: f64) -> View {
    View { origin, scale, right: DVec3::NEG_X, up: DVec3::Z }
}

/// Signed exit angles of scans.
fn scan() -> Picture {
    let mut picture = Picture::new(860, 640);
    let view = plane(DVec2::new(430.0, 310.0), 220.0);
    let light = Incidence { theta_deg: 45.0, phi_deg: 0.0 };
    let slab = [(-1.3, 0.0), (1.3, 0.0), (1.3, -0.08), (-1.3, -0.08)].map(|(x, z)| view.at(DVec3::new(x, 0.0, z)));
    picture.path(&slab, true, "fill=\"#e2e8f0\"");
    for below in [false, true] {
        let arc: Vec<DVec2> = (-90..=90).map(|a| view.at(light.in_plane(f64::from(a), below))).collect();
        picture.arc(&arc, FAINT);
        for angle in (-90i32..=90).step_by(15) {
            let d = light.in_plane(f64::from(angle), below);
            picture.line(view.at(d * 0.97), view.at(d * 1.03), FAINT, 1.5);
            let sign = if angle < 0 { "−" } else { "" };
            let nudge = if angle.abs() == 90 { DVec2::new(0.0, if below { 28.0 } else { -12.0 }) } else { DVec2::ZERO };
            if angle % 30 == 0 || angle.abs() == 45 {
                picture.label(view.at(d * 1.13) + nudge, INK, &format!("{sign}{}°", angle.abs()));
            }
        }
    }
    let origin = view.at(DVec3::ZERO);
    picture.dashed(&[view.at(DVec3::Z * 0.95), view.at(DVec3::NEG_Z * 0.95)]);
    picture.arrow(view.at(-light.propagation() * 0.94), view.at(-light.propagation() * 0.02), IN, 3.0);
    picture.arrow(origin, view.at(light.in_plane(45.0, false) * 0.94), OUT, 3.0);
    picture.arrow(origin, view.at(light.in_plane(20.0, false) * 0.94), OUT, 1.5);
    picture.arrow(origin, view.at(light.in_plane(45.0, true) * 0.94), THROUGH, 3.0);
    let labels = [
        ((0.58, 0.24), IN, "light, θᵢ = 45°"),
        ((-0.58, 0.24), OUT, "mirror, +45°"),
        ((-0.17, 0.80), OUT, "+20°"),
        ((-0.60, -0.26), THROUGH, "straight, +45°"),
        ((0.50, -0.42), INK, "with --below"),
    ];
    labels.iter().for_each(|&((x, z), colour, text)| picture.label(view.at(DVec3::new(x, 0.0, z)), colour, text));
    picture.label(DVec2::new(110.0, 40.0), INK, "negative: source side");
    picture.label(DVec2::new(750.0, 40.0), INK, "positive: mirror side");
    picture.label(DVec2::new(430.0, 618.0), INK, "plane of incidence, azimuth φᵢ; --azimuth turns the sample under it");
    picture
}

/// Directions of s and p for light that comes and light that goes.
fn polarization() -> Picture {
    let mut picture = Picture::new(860, 430);
    let view = plane(DVec2::new(430.0, 350.0), 300.0);
    let light = Incidence { theta_deg: 45.0, phi_deg: 0.0 };
    let slab = [(-1.2, 0.0), (1.2, 0.0), (1.2, -0.06), (-1.2, -0.06)].map(|(x, z)| view.at(DVec3::new(x, 0.0, z)));
    picture.path(&slab, true, "fill=\"#e2e8f0\"");
    let origin = view.at(DVec3::ZERO);
    picture.dashed(&[origin, view.at(DVec3::Z)]);
    picture.label(view.at(DVec3::Z * 1.05), INK, "z");
    picture.arrow(view.at(DVec3::X * 0.75 - DVec3::Z * 0.14), view.at(DVec3::X * 1.05 - DVec3::Z * 0.14), INK, 1.5);
    picture.label(view.at(DVec3::X * 1.1 - DVec3::Z * 0.14), INK, "x");
    let s = light.s_direction();
    let goes = light.in_plane(45.0, false);
    for (k, start, colour, prime) in
        [(light.propagation(), -light.propagation() * 1.12, IN, ""), (goes, DVec3::ZERO, OUT, "′")]
    {
        picture.arrow(view.at(start), view.at(start + k * 1.1), colour, 3.0);
        // The cross of k, s and p, half way.
        let middle = start + k * 0.56;
        let p = s.cross(k);
        picture.arrow(view.at(middle), view.at(middle + p * 0.3), INK, 2.5);
        picture.towards_us(view.at(middle), S);
        let aside = DVec2::new(if prime.is_empty() { -40.0 } else { 40.0 }, 0.0);
        picture.label(view.at(middle + p * 0.37) + aside, INK, &format!("p̂{prime} = ŝ × k̂{prime}"));
        picture.label(view.at(middle - p * 0.1), S, "ŝ");
        picture.label(view.at(middle + k * 0.30 - p * 0.1), colour, &format!("k̂{prime}"));
    }
    picture.label(DVec2::new(430.0, 412.0), S, "ŝ points out of the page, to us, for both");
    picture
}

/// Facets of the dome: all of one level, and some that are divided further.
fn dome() -> Picture {
    let mut picture = Picture::new(860, 470);
    let view = View::new(DVec2::new(270.0, 240.0), 205.0, -62.0, 22.0);
    let lobe = direction(40.0, 290.0);
    let mut facets: Vec<Facet> = Facet::all(2).collect();
    for nearer_deg in [32.0f64, 19.0, 10.0] {
        let divided = |f: Facet| {
            if f.center().angle_between(lobe) < nearer_deg.to_radians() { f.children().to_vec() } else { vec![f] }
        };
        facets = facets.into_iter().flat_map(divided).collect();
    }
    for facet in facets.iter().filter(|f| view.towards_us(f.center())) {
        let fill = match (facet.center().z > 0.0, facet.level) {
            (true, 2) => "#dbeafe",
            (true, 3) => "#bfdbfe",
            (true, 4) => "#93c5fd",
            (true, _) => "#60a5fa",
            (false, _) => "#d1fae5",
        };
        let corners = facet.corners().map(|c| view.at(c));
        picture.path(&corners, true, &format!("fill=\"{fill}\" stroke=\"{INK}\" stroke-width=\"0.7\""));
    }
    let mut equator: Vec<DVec2> = (0..=120)
        .map(|i| TAU * f64::from(i) / 120.0)
        .map(|a| DVec3::new(a.cos(), a.sin(), 0.0))
        .filter(|p| view.towards_us(*p))
        .map(|p| view.at(p))
        .collect();
    equator.sort_by(|a, b| a.x.total_cmp(&b.x));
    picture.path(&equator, false, &format!("fill=\"none\" stroke=\"{IN}\" stroke-width=\"2.5\""));
    picture.arrow(view.at(DVec3::Z), view.at(DVec3::Z * 1.2), INK, 1.5);
    picture.label(view.at(DVec3::Z * 1.2) + DVec2::new(14.0, 2.0), INK, "z");
    let notes = [
        (110.0, OUT, "above: reflection".to_string()),
        (140.0, INK, "facets of a lobe are divided into four,".into()),
        (164.0, INK, "and those again; where four do not".into()),
        (188.0, INK, "differ beyond noise, they are one".into()),
        (230.0, IN, "equator: no facet reaches over it".into()),
        (272.0, THROUGH, "below: transmission".into()),
        (314.0, INK, format!("level n: 20·4ⁿ facets, about {:.0}°/2ⁿ wide", width_deg())),
    ];
    notes.iter().for_each(|(y, colour, text)| picture.note(DVec2::new(500.0, *y), colour, text));
    picture
}

/// Width of a facet of level 0: an edge of the icosahedron.
fn width_deg() -> f64 {
    let [a, b, _] = Facet { level: 0, code: 0 }.corners();
    a.angle_between(b) * 180.0 / PI
}
