//! Numbers without a pattern, the same in every run: SplitMix64 (Steele, Lea and Flood 2014).

/// Draws from a seed.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        let bits = scatter(self.0);
        self.0 = self.0.wrapping_add(STEP);
        bits
    }

    /// Below `count`.
    pub fn below(&mut self, count: u32) -> u32 {
        (((self.bits() >> 32) * u64::from(count)) >> 32) as u32
    }

    /// From 0 to 1, which it does not reach.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 40) as f32 / (1u32 << 24) as f32
    }
}

const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

/// Spreads a word over all bits.
pub fn scatter(word: u64) -> u64 {
    let mut word = word.wrapping_add(STEP);
    word = (word ^ word >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    word = (word ^ word >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ word >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers from seed 1234567, as published with the algorithm's reference program.
    #[test]
    fn draws_the_known_numbers() {
        let mut random = Random(1_234_567);
        let drawn = [random.bits(), random.bits(), random.bits()];
        assert_eq!(drawn, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn keeps_to_its_ranges() {
        let mut random = Random(7);
        let drawn: Vec<u32> = (0..1000).map(|_| random.below(5)).collect();
        assert!((0..5).all(|number| drawn.contains(&number)) && drawn.iter().all(|&number| number < 5));
        assert!((0..1000).all(|_| (0.0..1.0).contains(&random.unit())));
    }
}
