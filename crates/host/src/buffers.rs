//! Numbers that are handed to a plugin, with guards around each array: a plugin that writes beyond one is found.

use std::ops::Range;

/// Numbers before and after each array.
const GUARD: usize = 8;
/// What they hold: a NaN that arithmetic does not produce.
const UNTOUCHED: u64 = 0x7ff8_4755_4152_4444;

/// Arrays of one call.
#[derive(Default)]
pub struct Buffers {
    numbers: Vec<f64>,
    arrays: Vec<(&'static str, Range<usize>)>,
}

/// An array of [`Buffers`].
#[derive(Clone, Copy)]
pub struct Array(usize);

impl Buffers {
    /// Begins a call.
    pub fn clear(&mut self) {
        self.numbers.clear();
        self.arrays.clear();
        self.guard();
    }

    fn guard(&mut self) {
        self.numbers.extend([f64::from_bits(UNTOUCHED); GUARD]);
    }

    /// Adds an array; `what` names it in messages.
    pub fn add(&mut self, what: &'static str, numbers: impl IntoIterator<Item = f64>) -> Array {
        let first = self.numbers.len();
        self.numbers.extend(numbers);
        self.arrays.push((what, first..self.numbers.len()));
        self.guard();
        Array(self.arrays.len() - 1)
    }

    /// First number of all arrays. The address is valid until the next one is added; that of an array is
    /// [`Self::offset`] further.
    pub fn address(&mut self) -> *mut f64 {
        self.numbers.as_mut_ptr()
    }

    /// Where an array begins.
    pub fn offset(&self, array: Array) -> usize {
        self.arrays[array.0].1.start
    }

    /// The numbers of an array.
    pub fn get(&self, array: Array) -> &[f64] {
        &self.numbers[self.arrays[array.0].1.clone()]
    }

    /// What was written outside of the arrays, if anything: text that continues a sentence about the plugin. A guard is
    /// between two arrays: what was written there is put down to the nearer one.
    pub fn overrun(&self) -> Option<String> {
        let touched = |guard: Range<usize>| guard.clone().find(|at| self.numbers[*at].to_bits() != UNTOUCHED);
        self.arrays.iter().enumerate().find_map(|(k, (what, range))| {
            let numbers = range.len();
            let behind = touched(range.end..range.end + GUARD);
            let before = touched(range.start - GUARD..range.start);
            if behind.is_some_and(|at| at < range.end + GUARD / 2 || k + 1 == self.arrays.len()) {
                Some(format!("wrote beyond the end of the array `{what}`, which has {numbers} numbers"))
            } else if before.is_some() {
                Some(format!("wrote before the beginning of the array `{what}`, which has {numbers} numbers"))
            } else {
                None
            }
        })
    }
}

/// A struct that a plugin fills in, with a guard behind it.
#[repr(C)]
pub struct Guarded<T> {
    /// The struct.
    pub value: T,
    behind: [u64; GUARD],
}

impl<T> Guarded<T> {
    /// With this struct.
    pub fn new(value: T) -> Self {
        Self { value, behind: [UNTOUCHED; GUARD] }
    }

    /// Where the struct is; the guard may be reached from there.
    pub fn address(&mut self) -> *mut T {
        (&raw mut *self).cast()
    }

    /// Whether something was written behind the struct.
    pub fn is_overrun(&self) -> bool {
        self.behind != [UNTOUCHED; GUARD]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(array: usize, at: isize) -> Option<String> {
        let mut buffers = Buffers::default();
        buffers.clear();
        let arrays = [buffers.add("one", [1.0, 2.0]), buffers.add("none", []), buffers.add("two", [3.0])];
        let place = buffers.offset(arrays[array]).checked_add_signed(at).expect("inside");
        buffers.numbers[place] = 7.0;
        buffers.overrun()
    }

    #[test]
    fn what_is_written_beside_an_array_is_put_down_to_it() {
        let beyond = |what: &str, n: u32| format!("wrote beyond the end of the array `{what}`, which has {n} numbers");
        for (array, at) in [(0, 0), (0, 1), (2, 0)] {
            assert_eq!(written(array, at), None);
        }
        assert_eq!(written(0, 2), Some(beyond("one", 2)));
        assert_eq!(written(0, 5), Some(beyond("one", 2)));
        assert_eq!(written(1, 0), Some(beyond("none", 0)));
        assert_eq!(written(2, 1), Some(beyond("two", 1)));
        assert_eq!(written(2, 8), Some(beyond("two", 1)));
        let before =
            |what: &str, n: u32| format!("wrote before the beginning of the array `{what}`, which has {n} numbers");
        assert_eq!(written(0, -1), Some(before("one", 2)));
        assert_eq!(written(2, -1), Some(before("two", 1)));
        assert_eq!(written(1, -2), Some(before("none", 0)));
    }
}
