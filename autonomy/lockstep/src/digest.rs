//! A fingerprint of everything a stack does, to compare two runs over one log.

use messages::{Input, StackEffect};
use stack::Stack;
use vocab::Stamp;

/// Anything with a stack's entrance, so that the check itself can be checked with a broken one.
pub trait Stepper {
    /// See [`Stack::step`].
    fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>);
}

impl Stepper for Stack {
    fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        Self::step(self, at, input, effects);
    }
}

/// BLAKE3 over the effects in their order, each with its instant.
#[derive(Clone, Debug, Default)]
pub struct Digest {
    hasher: blake3::Hasher,
    effects: u64,
}

impl Digest {
    /// Adds the effects of one step.
    pub fn add(&mut self, at: Stamp, effects: &[StackEffect]) {
        for effect in effects {
            self.hasher.update(&at.nanos().to_le_bytes());
            // An effect that cannot be encoded counts as nothing in both runs; postcard refuses none of these types.
            self.hasher.update(&postcard::to_stdvec(effect).unwrap_or_default());
            self.effects += 1;
        }
    }

    /// How many effects went in.
    pub fn effects(&self) -> u64 {
        self.effects
    }

    /// The fingerprint so far, 64 hexadecimal digits.
    pub fn hex(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// Steps a stack through a log and takes the fingerprint.
pub fn replay(log: impl IntoIterator<Item = (Stamp, Input)>, stack: &mut impl Stepper) -> Digest {
    let mut digest = Digest::default();
    let mut effects = Vec::new();
    for (at, input) in log {
        stack.step(at, input, &mut effects);
        digest.add(at, &effects);
        effects.clear();
    }
    digest
}
