//! What two exponents would do for lone triangles (MCT 3.6): `cargo run --release -p meshcolor-core --example lone_elongated --
//! MODEL...`. A model's other files are looked for beside it.
//!
//! Three tables: texels with one exponent and with two; what the diagonal costs in codes, by the paper's rule and by the exact one;
//! and the same on black and white noise. Faces are those of a conversion with the default options, before any share texels.

mod figures;
mod model;
mod random;
mod slanted;
mod study;

use std::error::Error;
use std::path::Path;

use figures::{decibels, percent};
use model::{Surface, all_channels, load};
use random::Random;
use slanted::{Grid, Triangle};
use study::{Cost, Study};

const NOISE_EXPONENTS: [[u8; 2]; 6] = [[2, 0], [2, 1], [3, 0], [3, 1], [4, 1], [4, 2]];
const NOISE_TRIANGLES: usize = 4000;

fn study(path: &Path) -> Result<Study, Box<dyn Error>> {
    let asset = load(path)?;
    let mut study = Study::default();
    for (material, channels) in all_channels(&asset).iter().enumerate() {
        if let Some(surface) = Surface::new(&asset, material, channels)? {
            study.add(&surface);
        }
    }
    Ok(study)
}

fn texels_row(name: &str, study: &Study) -> String {
    let Study { by_rule: rule, at_equal_error: equal, texels, .. } = study;
    let saved = |from: f64, to: f64| percent(from - to, *texels);
    let psnr = rule.squared.map(|squared| decibels(squared / rule.weight)).join(", ");
    format!(
        "| {name} | {} | {} | {} | {} | {:.0} | {:.0} | {:.0} | {} | {psnr} | {} | {} | {} |",
        study.triangle_count,
        study.lone_count,
        study.elongated_count,
        study.free_count,
        texels,
        rule.one_texels,
        rule.two_texels,
        saved(rule.one_texels, rule.two_texels),
        saved(equal.one_texels, equal.paper_texels),
        saved(equal.one_texels, equal.exact_texels),
        saved(equal.one_texels, equal.free_texels)
    )
}

fn cost_row(name: &str, cost: &mut Cost) -> String {
    format!(
        "| {name} | {} | {} | {} | {} |",
        cost.jump.text(),
        cost.jump.share_above(1.0),
        cost.paper_change.text(),
        cost.exact_change.text()
    )
}

/// Black and white samples in any order.
fn noise(exponents: [u8; 2]) -> Cost {
    let mut random = Random::new(u64::from(exponents[0]) << 8 | u64::from(exponents[1]));
    let mut cost = Cost::default();
    for _ in 0..NOISE_TRIANGLES {
        let samples = Triangle::new(Grid::new(exponents), |_| random.values().round());
        cost.add(&samples, |value| value * 255.0, 3);
    }
    cost
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut costs = Vec::new();
    println!(
        "| model | triangles | lone | elongated | diagonal free | texels, all faces | elongated: one exponent | two | saved, % of all | \
         dB: one, paper, exact | saved at equal error, %: paper | exact | free alone |"
    );
    println!("|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|");
    for path in std::env::args().skip(1) {
        let path = Path::new(&path);
        let study = study(path)?;
        let name = path.file_stem().and_then(|name| name.to_str()).ok_or("no file name")?;
        println!("{}", texels_row(name, &study));
        costs.push((name.to_owned(), study.cost));
    }
    for exponents in NOISE_EXPONENTS {
        costs.push((format!("noise, r = {}, s = {}", exponents[0], exponents[1]), noise(exponents)));
    }
    println!();
    println!(
        "| codes: mean, p99, most | paper: jump | over 1 code, % | paper: change of the diagonal | exact: change of the samples |"
    );
    println!("|---|--:|--:|--:|--:|");
    for (name, mut cost) in costs {
        println!("{}", cost_row(&name, &mut cost));
    }
    Ok(())
}
