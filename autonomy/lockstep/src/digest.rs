//! A digest of all effects of a stack, to compare two runs over one log.

use messages::{Input, StackEffect};
use stack::Stack;
use vocab::Stamp;

/// The interface of [`Stack::step`], so that the replay check can be tested with a faulty stack.
pub trait Stepper {
    /// See [`Stack::step`].
    fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>);
}

impl Stepper for Stack {
    fn step(&mut self, at: Stamp, input: Input, effects: &mut Vec<StackEffect>) {
        Self::step(self, at, input, effects);
    }
}

/// BLAKE3 hash over the effects in order, each with its time stamp.
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
            // An effect that cannot be encoded is ignored in both runs. Postcard can encode all of these types.
            self.hasher.update(&postcard::to_stdvec(effect).unwrap_or_default());
            self.effects += 1;
        }
    }

    /// Number of effects added.
    pub fn effects(&self) -> u64 {
        self.effects
    }

    /// The digest so far, 64 hexadecimal digits.
    pub fn hex(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// Steps a stack through a log and returns the digest.
pub fn replay(log: impl IntoIterator<Item = (Stamp, Input)>, stack: &mut impl Stepper) -> Digest {
    replay_with(log, stack, |_, _| {})
}

/// As [`replay`]; `see` gets the effects of each step, with the step's instant.
pub fn replay_with(
    log: impl IntoIterator<Item = (Stamp, Input)>,
    stack: &mut impl Stepper,
    mut see: impl FnMut(Stamp, &[StackEffect]),
) -> Digest {
    let mut digest = Digest::default();
    let mut effects = Vec::new();
    for (at, input) in log {
        stack.step(at, input, &mut effects);
        digest.add(at, &effects);
        see(at, &effects);
        effects.clear();
    }
    digest
}
