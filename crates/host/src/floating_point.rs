//! Control of the floating-point unit: rounding mode, flush to zero, exceptions that trap. It belongs to the thread,
//! and a plugin that changes it would change all results of this program after its call.

/// Control register of the unit, without its flags, which any arithmetic sets.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct FloatingPoint {
    register: u64,
    /// That of the x87 unit of old; zero elsewhere.
    x87: u16,
}

/// What bits of the control register control.
#[cfg(target_arch = "x86_64")]
const CONTROLS: [(u64, &str); 3] =
    [(0x6000, "rounding mode"), (0x8040, "flush to zero of subnormal numbers"), (0x1f80, "exceptions that trap")];
#[cfg(target_arch = "aarch64")]
const CONTROLS: [(u64, &str); 3] = [
    (0x00c0_0000, "rounding mode"),
    (0x0108_0000, "flush to zero of subnormal numbers"),
    (0x9f00, "exceptions that trap"),
];
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
const CONTROLS: [(u64, &str); 0] = [];

impl FloatingPoint {
    /// That of this thread.
    #[cfg(target_arch = "x86_64")]
    pub fn now() -> Self {
        let (mut register, mut x87) = (0_u32, 0_u16);
        // SAFETY: both instructions store a control register into memory that is theirs.
        unsafe {
            std::arch::asm!("stmxcsr [{}]", in(reg) &raw mut register, options(nostack, preserves_flags));
            std::arch::asm!("fnstcw [{}]", in(reg) &raw mut x87, options(nostack, preserves_flags));
        }
        Self { register: u64::from(register), x87 }.without_flags()
    }

    /// Makes it that of this thread again.
    #[cfg(target_arch = "x86_64")]
    pub fn restore(self) {
        let register = self.register as u32;
        // SAFETY: the values were read from the registers before; the flags are cleared, so that none traps.
        unsafe {
            std::arch::asm!("fnclex", "fldcw [{}]", in(reg) &raw const self.x87, options(nostack));
            std::arch::asm!("ldmxcsr [{}]", in(reg) &raw const register, options(nostack, preserves_flags));
        }
    }

    /// That of this thread.
    #[cfg(target_arch = "aarch64")]
    pub fn now() -> Self {
        let register: u64;
        // SAFETY: reads a control register.
        unsafe { std::arch::asm!("mrs {}, fpcr", out(reg) register, options(nomem, nostack, preserves_flags)) };
        Self { register, x87: 0 }.without_flags()
    }

    /// Makes it that of this thread again.
    #[cfg(target_arch = "aarch64")]
    pub fn restore(self) {
        // SAFETY: the value was read from the register before.
        unsafe { std::arch::asm!("msr fpcr, {}", in(reg) self.register, options(nomem, nostack, preserves_flags)) };
    }

    /// Not known on this processor.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub fn now() -> Self {
        Self { register: 0, x87: 0 }
    }

    /// Not known on this processor.
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    pub fn restore(self) {}

    fn without_flags(self) -> Self {
        Self { register: self.register & CONTROLS.iter().fold(0, |all, (bits, _)| all | bits), ..self }
    }

    /// What differs from it in `other`, in words; `None`: nothing.
    pub fn changed(self, other: Self) -> Option<String> {
        let differ = |bits: u64| (self.register ^ other.register) & bits != 0;
        let words: Vec<&str> = CONTROLS.iter().filter(|(bits, _)| differ(*bits)).map(|(_, words)| *words).collect();
        match (words.is_empty(), self.x87 == other.x87) {
            (false, _) => Some(words.join(" and ")),
            (true, false) => Some("control of the x87 unit".to_owned()),
            (true, true) => None,
        }
    }
}
