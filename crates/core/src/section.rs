//! Cross-section of a branch.

/// Cross-section of a branch. All values are per unstressed length, in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Section {
    /// Name in the scenario.
    pub name: String,
    /// Outer diameter, m.
    pub diameter: f64,
    /// Mass per length, kg/m.
    pub linear_density: f64,
    /// Axial stiffness EA, N.
    pub axial_stiffness: f64,
    /// Shear stiffness GA along d1 and d2, N.
    pub shear_stiffness: [f64; 2],
    /// Bending stiffness EI about d1 and d2, N m².
    pub bending_stiffness: [f64; 2],
    /// Torsion stiffness GJ, N m².
    pub torsion_stiffness: f64,
    /// Smallest bend radius allowed, m; the run reports smaller ones.
    pub min_bend_radius: Option<f64>,
    /// Smallest bend radius allowed while the branch moves, m: the dynamic one of data sheets.
    pub min_bend_radius_moving: Option<f64>,
    /// Largest tension allowed, N; of a bundle by default the tension that breaks its first conductor.
    pub max_tension: Option<f64>,
    /// Largest twist allowed beyond that at rest, either way, rad/m.
    pub max_torsion: Option<f64>,
}

impl Section {
    /// Diagonal of the stretch-shear stiffness `diag(GA1, GA2, EA)`, N.
    pub fn stretch_diagonal(&self) -> crate::Vector {
        crate::Vector::new(self.shear_stiffness[0], self.shear_stiffness[1], self.axial_stiffness)
    }

    /// Diagonal of the bend-twist stiffness `diag(EI1, EI2, GJ)`, N m².
    pub fn bend_diagonal(&self) -> crate::Vector {
        crate::Vector::new(self.bending_stiffness[0], self.bending_stiffness[1], self.torsion_stiffness)
    }
}
