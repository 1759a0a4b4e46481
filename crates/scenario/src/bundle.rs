//! The rule for sections: stiffness, mass and size of a bundle from its wires and coverings.
//!
//! The sources and uncertainties of the shipped wires, coverings and materials are given in `library/README.md`. SI
//! units throughout; everything is per unstressed length.
//!
//! **Two bounds.** Strands in a conductor, wires in a bundle and turns of a tape either slide on each other without
//! friction (*slip*: each bends about its own axis) or stick (*bonded*: all bend about the axis of the bundle). These
//! differ by two to four powers of ten, so the value taken lies between them on a logarithmic scale, at a fraction c,
//! the *cohesion*:
//!
//! ```text
//! X(c) = X_slip^(1−c) · X_bonded^c,       0 ≤ c ≤ 1
//! ```
//!
//! **A wire**: n strands of diameter d (A = n π d²/4) in a conductor of diameter D_c, and layers with outer and inner
//! diameters D, D_i over it; ν Poisson's ratio, ρ density, φ the fraction of a layer that is filled.
//!
//! ```text
//!            slip                    bonded
//! conductor  EI = E A d²/16          EI = k E A D_c²/16          EA = k E A        (k = 1 for a solid conductor)
//! layer      EI = E φ π (D⁴ − D_i⁴)/64                           EA = E φ π (D² − D_i²)/4
//! braid      EI = E A_b d_b²/16      EI = k_b E φ π (D⁴−D_i⁴)/64  EA = k_b E A_b, A_b = φ π (D² − D_i²)/4
//! torsion    GJ = EI/(1 + ν) of each part                        (G J = E/(2(1+ν)) · 2 I)
//! mass       Σ ρ A
//! ```
//!
//! The wire's own EI_w, GJ_w lie between its bounds at [`STRAND_COHESION`]. Its conductor's stranding lays it
//! helically, hence k = [`STRANDING`] and k_b = [`BRAIDING`].
//!
//! **A bundle** of N wires, spread evenly over a circle of diameter D_b:
//!
//! ```text
//! D_b    = max(√(Σ D_w²/packing), D_1 + D_2)       D_1, D_2 the two thickest; the wire's own D for one wire
//! slip   : EI = Σ EI_w(slip),     GJ = Σ GJ_w(slip)
//! sliding: EI = Σ EI_w,           GJ = Σ GJ_w                         (c = 0: wires slide, strands as in one wire)
//! bonded : EI = Σ EI_w(bonded) + Σ EA_w (D_b² − D_w²)/16    (parallel axes: Σ A r² of an even spread is A D²/16)
//!          GJ = Σ GJ_w(bonded) + Σ EA_w/(2(1+ν)) (D_b² − D_w²)/8
//! EA     = Σ EA_w
//! ```
//!
//! The value taken lies between *sliding* and *bonded* at the largest cohesion of the coverings, [`LOOSE`] without
//! any; a single wire has nothing to be bound to: c = 0. Where the friction of a section says how its wires stick in
//! bending, c = 0 there too.
//!
//! **A covering** is a shell of wall t and mean diameter around what it covers. A tube counts in both bounds, a wrap
//! (tape, braid), whose turns slide, in the bonded one only:
//!
//! ```text
//! EI = b E π (D⁴ − D_i⁴)/64,        GJ = a E/(1+ν) π (D⁴ − D_i⁴)/64,
//! EA = b E π (D² − D_i²)/4,         mass = ρ π (D² − D_i²)/4
//! ```
//!
//! all times the fraction of the surface that it covers; b (bending, stretch) and a (torsion) are the fractions of a
//! plain wall's stiffness that corrugation, laps or a slit leave. A covering over a fraction f of a branch: parts with
//! different stiffness act in series, 1/X = Σ f_i/X_i. Several such coverings lie over each other, from one end.
//!
//! **Minimum bend radius**: the largest of those of the wires (by default [`BEND_RADIUS`] · D_w), those of the
//! coverings, and [`BEND_RADIUS`] times the diameter of two or more wires.
//!
//! **Largest tension**: that at which the first conductor breaks. Only conductors count; all of them have the strain ε
//! of the bundle, and σ is the strength of their material:
//!
//! ```text
//! T = min (σ_w/E_w) · Σ k_w E_w A_w        = k σ A of all conductors, where they are of one material
//! ```
//!
//! With several materials the sum of their strengths, Σ k σ A, is larger: it assumes that the one which comes to its
//! strength first yields on while the others catch up. A conductor that breaks or necks is a fault of the harness, so
//! the smaller value is taken. A strand bears k times the sum of its wires ([`STRANDING`]; ASTM B416 takes 90 % too).

use std::f64::consts::PI;

/// k: axial stiffness of a stranded conductor relative to a solid one of the same area. A lay angle β of 10° to 15°
/// gives cos³ β = 0.96 to 0.90; strands that are not yet tight reduce it further.
pub const STRANDING: f64 = 0.9;
/// k_b: the same for a braid that lies at 30° to 40° to the axis: cos³ β = 0.65 to 0.45, less where it can narrow.
pub const BRAIDING: f64 = 0.4;
/// Fraction of a conductor's circle that its strands fill if its diameter is not given: 7 equal strands fill 0.78,
/// bunched ones somewhat less.
pub const STRAND_PACKING: f64 = 0.75;
/// Fraction of a bundle's circle that its wires fill: 7 equal wires fill 0.78, random bundles about 0.7 to 0.8. The
/// workshop rule D = 1.2 √ΣD² gives 0.69.
pub const PACKING: f64 = 0.75;
/// c of strands in a conductor. Insulation presses them on each other; a 0.5 mm² wire becomes 1.4 times as stiff as
/// with frictionless strands.
pub const STRAND_COHESION: f64 = 0.1;
/// c of wires that nothing binds: 24 wires of 0.5 mm² become 1.4 times as stiff as their sum.
pub const LOOSE: f64 = 0.05;
/// Default ratio of minimum bend radius to diameter of bundles and wires: usual for fixed installation.
pub const BEND_RADIUS: f64 = 4.0;

/// A material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// E, Pa, at small strains and room temperature.
    pub modulus: f64,
    /// ν.
    pub poisson: f64,
    /// ρ, kg/m³.
    pub density: f64,
    /// σ, Pa: tensile strength; `None` if unknown.
    pub strength: Option<f64>,
}

/// A layer over a conductor: insulation, shield or jacket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Its material.
    pub material: Material,
    /// D, m: its outer diameter.
    pub diameter: f64,
    /// φ: fraction of the ring that is filled.
    pub fill: f64,
    /// d_b, m: diameter of its strands, if it is a braid.
    pub strand: Option<f64>,
}

impl Measured {
    /// These values, completed by those of `other`.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            linear_density: self.linear_density.or(other.linear_density),
            axial_stiffness: self.axial_stiffness.or(other.axial_stiffness),
            bending_stiffness: self.bending_stiffness.or(other.bending_stiffness),
            torsion_stiffness: self.torsion_stiffness.or(other.torsion_stiffness),
            min_bend_radius: self.min_bend_radius.or(other.min_bend_radius),
        }
    }
}

/// A wire as the library describes it.
#[derive(Clone, Debug, PartialEq)]
pub struct Wire {
    /// n.
    pub strands: usize,
    /// d, m.
    pub strand: f64,
    /// Material of the conductor.
    pub conductor: Material,
    /// D_c, m: see [`Wire::conductor_diameter_of`].
    pub conductor_diameter: f64,
    /// Layers from the inside, at least one.
    pub layers: Vec<Layer>,
    /// Measured values, which replace those of the rule.
    pub measured: Measured,
}

/// Measured values of a wire or covering.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measured {
    /// kg/m.
    pub linear_density: Option<f64>,
    /// EA, N.
    pub axial_stiffness: Option<f64>,
    /// EI, N m².
    pub bending_stiffness: Option<f64>,
    /// GJ, N m².
    pub torsion_stiffness: Option<f64>,
    /// m.
    pub min_bend_radius: Option<f64>,
}

/// A covering of a bundle, or of a part of its length.
#[derive(Clone, Debug, PartialEq)]
pub struct Covering {
    /// Its material.
    pub material: Material,
    /// m: the wall, or one layer of a tape.
    pub thickness: f64,
    /// Number of layers on each other.
    pub layers: usize,
    /// Whether it is wound or braided, so that its turns may slide on each other.
    pub wrap: bool,
    /// Fraction of the surface that it covers.
    pub coverage: f64,
    /// Inner diameter, m; `None`: that of the contents.
    pub inner_diameter: Option<f64>,
    /// Outer diameter, m; of a corrugated tube over the crests; `None`: that of the wall on the inner diameter.
    pub outer_diameter: Option<f64>,
    /// b.
    pub bending_share: f64,
    /// a.
    pub torsion_share: f64,
    /// c of the wires under it.
    pub cohesion: f64,
    /// Measured values, which replace those of the rule.
    pub measured: Measured,
}

/// A value and the bounds it lies between.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Between {
    /// Value if everything slides.
    pub slip: f64,
    /// The value taken.
    pub taken: f64,
    /// Value if everything sticks.
    pub bonded: f64,
}

impl Between {
    /// A value with equal bounds.
    pub fn exactly(value: f64) -> Self {
        Self { slip: value, taken: value, bonded: value }
    }

    /// `X_slip^(1−c) · X_bonded^c`, with `self.taken` as the value for sliding.
    fn at(self, c: f64) -> Self {
        let (low, high) = (self.taken.min(self.bonded), self.bonded);
        let taken = if low > 0.0 { low.powf(1.0 - c) * high.powf(c) } else { 0.0 };
        // Round-off must not carry it past a bound.
        Self { taken: taken.max(self.slip).min(self.bonded), ..self }
    }

    fn combine(self, other: Self, by: impl Fn(f64, f64) -> f64) -> Self {
        Self {
            slip: by(self.slip, other.slip),
            taken: by(self.taken, other.taken),
            bonded: by(self.bonded, other.bonded),
        }
    }

    fn plus(self, other: Self) -> Self {
        self.combine(other, |a, b| a + b)
    }

    fn times(self, factor: f64) -> Self {
        self.combine(self, |a, _| a * factor)
    }
}

/// `π (D⁴ − D_i⁴)/64`, m⁴.
fn ring_moment(outer: f64, inner: f64) -> f64 {
    PI / 64.0 * (outer.powi(4) - inner.powi(4))
}

/// `π (D² − D_i²)/4`, m².
fn ring_area(outer: f64, inner: f64) -> f64 {
    0.25 * PI * (outer.powi(2) - inner.powi(2))
}

impl Wire {
    /// `d √(n/STRAND_PACKING)`, the default diameter of a conductor, m; d for a single strand.
    pub fn conductor_diameter_of(strands: usize, strand: f64) -> f64 {
        if strands == 1 { strand } else { strand * (strands as f64 / STRAND_PACKING).sqrt() }
    }

    /// A, m²: of the metal of the conductor.
    pub fn conductor_area(&self) -> f64 {
        self.strands as f64 * ring_area(self.strand, 0.0)
    }

    /// D, m.
    pub fn diameter(&self) -> f64 {
        self.layers.last().map_or(self.conductor_diameter, |layer| layer.diameter)
    }

    /// The layers with their inner diameters.
    fn rings(&self) -> impl Iterator<Item = (&Layer, f64)> {
        let inner = std::iter::once(self.conductor_diameter).chain(self.layers.iter().map(|layer| layer.diameter));
        self.layers.iter().zip(inner)
    }

    /// Mass per length, kg/m.
    pub fn linear_density(&self) -> f64 {
        self.measured.linear_density.unwrap_or_else(|| {
            let layers = self.rings().map(|(l, inner)| l.material.density * l.fill * ring_area(l.diameter, inner));
            self.conductor.density * self.conductor_area() + layers.sum::<f64>()
        })
    }

    /// k of the conductor.
    fn stranding(&self) -> f64 {
        if self.strands == 1 { 1.0 } else { STRANDING }
    }

    /// EA, N.
    pub fn axial_stiffness(&self) -> f64 {
        self.measured.axial_stiffness.unwrap_or_else(|| {
            let layers = self.rings().map(|(l, inner)| {
                let k = if l.strand.is_some() { BRAIDING } else { 1.0 };
                k * l.material.modulus * l.fill * ring_area(l.diameter, inner)
            });
            self.conductor_stiffness() + layers.sum::<f64>()
        })
    }

    /// k E A of the conductor, N.
    fn conductor_stiffness(&self) -> f64 {
        self.stranding() * self.conductor.modulus * self.conductor_area()
    }

    /// EI of the conductor and of each layer with ν of their materials; N m².
    fn parts(&self) -> Vec<(Between, f64)> {
        let conductor = self.conductor.modulus * self.conductor_area() / 16.0;
        let slip = conductor * self.strand.powi(2);
        let bonded = (self.stranding() * conductor * self.conductor_diameter.powi(2)).max(slip);
        let mut parts = vec![(Between { slip, taken: slip, bonded }, self.conductor.poisson)];
        for (l, inner) in self.rings() {
            let solid = l.material.modulus * l.fill * ring_moment(l.diameter, inner);
            let ei = match l.strand {
                None => Between::exactly(solid),
                Some(d) => {
                    let slip = l.material.modulus * l.fill * ring_area(l.diameter, inner) * d.powi(2) / 16.0;
                    Between { slip, taken: slip, bonded: (BRAIDING * solid).max(slip) }
                }
            };
            parts.push((ei, l.material.poisson));
        }
        parts
    }

    /// EI, N m².
    pub fn bending_stiffness(&self) -> Between {
        match self.measured.bending_stiffness {
            Some(measured) => Between::exactly(measured),
            None => self.parts().into_iter().fold(Between::default(), |sum, (ei, _)| sum.plus(ei)).at(STRAND_COHESION),
        }
    }

    /// GJ, N m².
    pub fn torsion_stiffness(&self) -> Between {
        match self.measured.torsion_stiffness {
            Some(measured) => Between::exactly(measured),
            None => self
                .parts()
                .into_iter()
                .fold(Between::default(), |sum, (ei, poisson)| sum.plus(ei.times(1.0 / (1.0 + poisson))))
                .at(STRAND_COHESION),
        }
    }

    /// Smallest bend radius, m.
    pub fn min_bend_radius(&self) -> f64 {
        self.measured.min_bend_radius.unwrap_or(BEND_RADIUS * self.diameter())
    }
}

/// A covering on a bundle.
struct Shell {
    /// Outside, m.
    diameter: f64,
    linear_density: f64,
    axial_stiffness: f64,
    bending: Between,
    torsion: Between,
}

impl Covering {
    /// t, m: all layers together.
    pub fn wall(&self) -> f64 {
        self.thickness * self.layers as f64
    }

    /// Inner and outer diameter of the covering on something of this diameter, m.
    pub fn diameters(&self, diameter: f64) -> [f64; 2] {
        let inner = self.inner_diameter.unwrap_or(0.0).max(diameter);
        [inner, self.outer_diameter.unwrap_or(0.0).max(inner + 2.0 * self.wall())]
    }

    /// The covering on something of this diameter, m.
    fn around(&self, diameter: f64) -> Shell {
        let t = self.wall();
        let [lies_at, outer] = self.diameters(diameter);
        // The wall of a corrugated tube runs to and fro between its diameters: taken in their middle.
        let inner = match (self.inner_diameter, self.outer_diameter) {
            (Some(inner), Some(outer)) => 0.5 * (inner + outer) - t,
            _ => lies_at,
        };
        let (area, moment) = (ring_area(inner + 2.0 * t, inner), ring_moment(inner + 2.0 * t, inner));
        let b = self.bending_share * self.coverage * self.material.modulus;
        let a = self.torsion_share * self.coverage * self.material.modulus / (1.0 + self.material.poisson);
        let shell = |measured: Option<f64>, rule: f64| match measured {
            Some(measured) => Between::exactly(measured),
            None if self.wrap => Between { bonded: rule, ..Between::default() },
            None => Between::exactly(rule),
        };
        let measured = &self.measured;
        Shell {
            diameter: outer,
            linear_density: measured.linear_density.unwrap_or(self.material.density * self.coverage * area),
            axial_stiffness: measured.axial_stiffness.unwrap_or(b * area),
            bending: shell(measured.bending_stiffness, b * moment),
            torsion: shell(measured.torsion_stiffness, a * moment),
        }
    }
}

/// Wires of one type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wires<'a> {
    /// The type.
    pub wire: &'a Wire,
    /// Their number, at least one.
    pub count: usize,
}

/// A covering and the fraction of the branch that it covers, above 0, at most 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covered<'a> {
    /// The covering.
    pub covering: &'a Covering,
    /// The fraction.
    pub fraction: f64,
}

/// A bundle by the rule.
#[derive(Clone, Debug, PartialEq)]
pub struct Bundle {
    /// Number of wires.
    pub wires: usize,
    /// Outside diameter, m.
    pub diameter: f64,
    /// Diameter of the wires without coverings, m.
    pub wires_diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// EA, N.
    pub axial_stiffness: f64,
    /// EI, N m².
    pub bending: Between,
    /// GJ, N m².
    pub torsion: Between,
    /// Smallest bend radius, m.
    pub min_bend_radius: f64,
    /// T, N: tension that breaks the first conductor; `None` if the strength of one of them is unknown.
    pub max_tension: Option<f64>,
    /// Σ EI_w of the separate wires, N m².
    pub wires_bending: f64,
}

/// A part of a branch under the same coverings.
struct Stretch {
    fraction: f64,
    diameter: f64,
    linear_density: f64,
    axial_stiffness: f64,
    bending: Between,
    torsion: Between,
}

impl Bundle {
    /// Wires under coverings (inside out). `packing` and `cohesion` replace [`PACKING`] and the coverings' cohesion.
    ///
    /// # Panics
    /// Without wires.
    pub fn new(contents: &[Wires<'_>], coverings: &[Covered<'_>], packing: Option<f64>, cohesion: Option<f64>) -> Self {
        let count: usize = contents.iter().map(|wires| wires.count).sum();
        assert!(count > 0, "a bundle has wires");
        let wires_diameter = wires_diameter(contents, count, packing.unwrap_or(PACKING));
        let bare = bare(contents, wires_diameter);

        // From one end: under all coverings, then under fewer and fewer, then bare.
        let mut ends: Vec<f64> = coverings.iter().map(|covered| covered.fraction).chain([1.0]).collect();
        ends.sort_by(f64::total_cmp);
        let mut stretches = Vec::new();
        let mut from = 0.0;
        for to in ends {
            if to > from {
                let here: Vec<&Covering> =
                    coverings.iter().filter(|covered| covered.fraction >= to).map(|covered| covered.covering).collect();
                let bound = here.iter().map(|covering| covering.cohesion).fold(LOOSE, f64::max);
                let c = cohesion.unwrap_or(if count == 1 { 0.0 } else { bound });
                stretches.push(stretch(&bare, &here, to - from, c));
                from = to;
            }
        }
        let mean = |of: fn(&Stretch) -> f64| stretches.iter().map(|s| s.fraction * of(s)).sum::<f64>();
        let in_series = |of: &dyn Fn(&Stretch) -> f64| 1.0 / stretches.iter().map(|s| s.fraction / of(s)).sum::<f64>();
        let bounds_in_series = |of: fn(&Stretch) -> Between| {
            let [slip, taken, bonded] =
                [in_series(&|s| of(s).slip), in_series(&|s| of(s).taken), in_series(&|s| of(s).bonded)];
            Between { slip, taken: taken.max(slip).min(bonded), bonded }
        };
        let allowed = contents.iter().map(|wires| wires.wire.min_bend_radius());
        let allowed = allowed.chain(coverings.iter().filter_map(|covered| covered.covering.measured.min_bend_radius));
        let by_size = if count == 1 { 0.0 } else { BEND_RADIUS * wires_diameter };
        Self {
            wires: count,
            diameter: stretches.iter().map(|s| s.diameter).fold(0.0, f64::max),
            wires_diameter,
            linear_density: mean(|s| s.linear_density),
            axial_stiffness: in_series(&|s| s.axial_stiffness),
            bending: bounds_in_series(|s| s.bending),
            torsion: bounds_in_series(|s| s.torsion),
            min_bend_radius: allowed.fold(by_size, f64::max),
            max_tension: max_tension(contents),
            wires_bending: contents.iter().map(|w| w.count as f64 * w.wire.bending_stiffness().taken).sum(),
        }
    }
}

/// T = min (σ_w/E_w) · Σ k_w E_w A_w, N; `None` if a strength is unknown.
fn max_tension(contents: &[Wires<'_>]) -> Option<f64> {
    let strains = contents.iter().map(|w| Some(w.wire.conductor.strength? / w.wire.conductor.modulus));
    let first = strains.collect::<Option<Vec<f64>>>()?.into_iter().fold(f64::INFINITY, f64::min);
    Some(first * contents.iter().map(|w| w.count as f64 * w.wire.conductor_stiffness()).sum::<f64>())
}

/// D_b, m.
fn wires_diameter(contents: &[Wires<'_>], count: usize, packing: f64) -> f64 {
    let mut thickest: Vec<f64> =
        contents.iter().flat_map(|w| std::iter::repeat_n(w.wire.diameter(), w.count.min(2))).collect();
    thickest.sort_by(|a, b| b.total_cmp(a));
    if count == 1 {
        return thickest[0];
    }
    let squares: f64 = contents.iter().map(|w| w.count as f64 * w.wire.diameter().powi(2)).sum();
    (squares / packing).sqrt().max(thickest[0] + thickest[1])
}

/// All wires together, nothing around them; `taken`: wires slide, strands as in one wire.
fn bare(contents: &[Wires<'_>], diameter: f64) -> Stretch {
    let mut sum = Stretch {
        fraction: 1.0,
        diameter,
        linear_density: 0.0,
        axial_stiffness: 0.0,
        bending: Between::default(),
        torsion: Between::default(),
    };
    for Wires { wire, count } in contents {
        let n = *count as f64;
        let ea = wire.axial_stiffness();
        let apart = (diameter.powi(2) - wire.diameter().powi(2)).max(0.0);
        let parallel = |value| Between { bonded: value, ..Between::default() };
        sum.linear_density += n * wire.linear_density();
        sum.axial_stiffness += n * ea;
        sum.bending = sum.bending.plus(wire.bending_stiffness().plus(parallel(ea * apart / 16.0)).times(n));
        let ga = ea / (2.0 * (1.0 + wire.conductor.poisson));
        sum.torsion = sum.torsion.plus(wire.torsion_stiffness().plus(parallel(ga * apart / 8.0)).times(n));
    }
    sum
}

/// The bare wires under these coverings, with cohesion c.
fn stretch(bare: &Stretch, coverings: &[&Covering], fraction: f64, c: f64) -> Stretch {
    let mut sum = Stretch { fraction, ..*bare };
    for covering in coverings {
        let shell = covering.around(sum.diameter);
        sum.diameter = shell.diameter;
        sum.linear_density += shell.linear_density;
        sum.axial_stiffness += shell.axial_stiffness;
        sum.bending = sum.bending.plus(shell.bending);
        sum.torsion = sum.torsion.plus(shell.torsion);
    }
    Stretch { bending: sum.bending.at(c), torsion: sum.torsion.at(c), ..sum }
}
