//! Reference of `shared/bindings.wgsl`: access to entries of a variant, in addition to those of [`crate::memory`].

use crate::harness::NONE;
use crate::memory::{Matrix, Memory, Rotation, Vector};
use nalgebra::Quaternion;

impl Memory {
    pub(crate) fn word(&self, at: usize) -> u32 {
        self.program[at]
    }

    pub(crate) fn number(&self, entry: usize, variant: usize) -> f64 {
        self.numbers[self.at(entry, variant)]
    }

    pub(crate) fn number3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.number(entry + i, variant))
    }

    pub(crate) fn number4(&self, entry: usize, variant: usize) -> Rotation {
        Quaternion::from([0, 1, 2, 3].map(|i| self.number(entry + i, variant)))
    }

    pub(crate) fn gradient_entry(&self, variable: usize, slot: u32, variant: usize) -> usize {
        self.gradient_of((self.control[variant].current + slot) % 3, variable)
    }

    pub(crate) fn gradient_of(&self, own: u32, variable: usize) -> usize {
        self.offsets.gradient_vectors as usize + (own as usize * self.offsets.variables as usize + variable) * 3
    }

    pub(crate) fn value3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.state[self.at(entry + i, variant)])
    }

    pub(crate) fn value4(&self, entry: usize, variant: usize) -> Rotation {
        Quaternion::from([0, 1, 2, 3].map(|i| self.state[self.at(entry + i, variant)]))
    }

    pub(crate) fn compensation3(&self, entry: usize, variant: usize) -> Vector {
        self.value3(entry + 4, variant)
    }

    pub(crate) fn set_value3(&mut self, entry: usize, variant: usize, x: &Vector) {
        for i in 0..3 {
            let at = self.at(entry + i, variant);
            self.state[at] = x[i];
        }
    }

    pub(crate) fn set_value4(&mut self, entry: usize, variant: usize, q: &Rotation) {
        for i in 0..4 {
            let at = self.at(entry + i, variant);
            self.state[at] = q.coords[i];
        }
    }

    pub(crate) fn edge(&self, a: usize, b: usize, variant: usize) -> Vector {
        (self.value3(b, variant) - self.value3(a, variant))
            + (self.compensation3(b, variant) - self.compensation3(a, variant))
    }

    pub(crate) fn motion(&self, variable: usize, variant: usize) -> Vector {
        let hold = self.word(self.offsets.holds_program as usize + variable);
        if hold == NONE || self.control[variant].moving == 0 {
            return Vector::zeros();
        }
        self.number3(self.offsets.holds_numbers as usize + 20 * hold as usize + 17, variant)
    }

    pub(crate) fn part3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.parts[self.at(entry + i, variant)])
    }

    pub(crate) fn part33(&self, entry: usize, variant: usize) -> Matrix {
        Matrix::from_fn(|i, k| self.parts[self.at(entry + 3 * k + i, variant)])
    }

    pub(crate) fn set_part3(&mut self, entry: usize, variant: usize, x: &Vector) {
        for i in 0..3 {
            let at = self.at(entry + i, variant);
            self.parts[at] = x[i];
        }
    }

    pub(crate) fn set_part33(&mut self, entry: usize, variant: usize, m: &Matrix) {
        for i in 0..9 {
            let at = self.at(entry + i, variant);
            self.parts[at] = m[i];
        }
    }

    pub(crate) fn block33(&self, block: usize, variant: usize) -> Matrix {
        Matrix::from_fn(|i, k| self.blocks[self.at(9 * block + 3 * k + i, variant)])
    }

    pub(crate) fn set_block33(&mut self, block: usize, variant: usize, m: &Matrix) {
        for i in 0..9 {
            let at = self.at(9 * block + i, variant);
            self.blocks[at] = m[i];
        }
    }

    pub(crate) fn vector(&self, entry: usize, variant: usize) -> f64 {
        self.vectors[self.at(entry, variant)]
    }

    pub(crate) fn vector3(&self, entry: usize, variant: usize) -> Vector {
        Vector::from_fn(|i, _| self.vector(entry + i, variant))
    }

    pub(crate) fn set_vector(&mut self, entry: usize, variant: usize, x: f64) {
        let at = self.at(entry, variant);
        self.vectors[at] = x;
    }

    pub(crate) fn set_vector3(&mut self, entry: usize, variant: usize, x: &Vector) {
        for i in 0..3 {
            self.set_vector(entry + i, variant, x[i]);
        }
    }
}
