//! Ptex files: converted, and held against Ptex's own bilinear filter, which is evaluated from what was written.

use glam::{Vec2, Vec3};
use meshcolor::measure::Verdict;
use meshcolor::pipeline::{Conversion, Options, convert};
use meshcolor::read::{Limits, Upload};
use meshcolor::watch::Unwatched;
use meshcolor_tests::openimageio;
use meshcolor_tests::patches::Random;
use meshcolor_tests::ptex::writer::{self, Ptex, Stored};
use meshcolor_tests::ptex::{self, Painted};
use meshcolor_tests::reading::shown_codes;
use meshcolor_tests::validator;

/// How far two functions are apart, in 8-bit codes.
#[derive(Clone, Copy, Debug, Default)]
struct Distance {
    sum: f64,
    largest: f32,
    count: usize,
}

impl Distance {
    fn add(&mut self, shown: Vec3, expected: Vec3) {
        let difference = (shown - expected).abs();
        self.sum += f64::from(difference.length_squared());
        self.largest = self.largest.max(difference.max_element());
        self.count += 3;
    }

    fn root_mean_square(&self) -> f64 {
        (self.sum / self.count as f64).sqrt()
    }
}

impl std::fmt::Display for Distance {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rms = self.root_mean_square();
        let psnr = 20.0 * (255.0 / rms).log10();
        write!(f, "{rms:.3} codes ({psnr:.1} dB), at most {:.2}, {} points", self.largest, self.count / 3)
    }
}

fn converted(painted: &Painted, options: &[(&str, &str)]) -> Conversion {
    let mut wanted = Options::default();
    for (name, value) in options {
        wanted.set(name, value).unwrap();
    }
    convert(&painted.upload(), &wanted, &Limits::default(), &Unwatched).unwrap()
}

fn codes(linear: Vec3) -> Vec3 {
    linear.map(|v| 255.0 * if v <= 0.003_130_8 { v * 12.92 } else { 1.055 * v.powf(1.0 / 2.4) - 0.055 })
}

/// What the converted texture shows at a point of a face, in 8-bit codes.
fn shown(conversion: &Conversion, painted: &Painted, face: usize, [s, t]: [f32; 2]) -> Vec3 {
    let piece = &conversion.finished.primitives[0];
    let (triangle, weights) = match painted.faces[face].len() {
        3 => (face, [1.0 - s - t, s, t]),
        _ if t <= s => (2 * face, [1.0 - s, s - t, t]),
        _ => (2 * face + 1, [1.0 - t, s, t - s]),
    };
    let at: Vec2 = (0..3).map(|corner| piece.place(triangle, corner, 0) * weights[corner]).sum();
    let texture = &conversion.finished.textures[0];
    shown_codes(&texture.levels[0], texture.transfer, at)
}

fn random_point(corner_count: usize, random: &mut Random) -> [f32; 2] {
    let [s, t] = [random.unit(), random.unit()];
    if corner_count == 3 && s + t > 1.0 { [1.0 - s, 1.0 - t] } else { [s, t] }
}

/// Compares at random points where `expected` knows a value.
fn distance(
    conversion: &Conversion,
    painted: &Painted,
    expected: impl Fn(usize, [f32; 2]) -> Option<Vec3>,
) -> Distance {
    let mut random = Random::new(1);
    let mut distance = Distance::default();
    for _ in 0..20_000 {
        let face = random.below(painted.faces.len());
        let at = random_point(painted.faces[face].len(), &mut random);
        if let Some(expected) = expected(face, at) {
            distance.add(shown(conversion, painted, face, at), codes(expected));
        }
    }
    assert!(distance.count > 9_000, "only {} points are known", distance.count / 3);
    distance
}

/// Nothing is cut, and sides differ by rounding: half a code of those that are stored.
fn assert_seamless(conversion: &Conversion) {
    let report = &conversion.report;
    let rounding = if report.channels[0].bits == 8 { 0.501 } else { 0.002 };
    assert!(report.verdict != Verdict::Fail, "{:?}", report.verdict);
    assert!(report.max_seam_delta_codes <= rounding, "{} codes", report.max_seam_delta_codes);
    assert_eq!(report.channels[0].cuts.cut_share, 0.0, "nothing is cut");
}

/// The converted texture beside the bilinear filter, by resolution rule, as root mean square codes.
fn by_rule(name: &str, painted: &Painted) -> [f64; 4] {
    let rules: [(&str, &[(&str, &str)]); 4] = [
        ("default", &[]),
        ("fitted", &[("sampling", "fitted")]),
        ("one finer", &[("resolution", "area:4")]),
        ("one finer, fitted", &[("resolution", "area:4"), ("sampling", "fitted")]),
    ];
    rules.map(|(rule, options)| {
        let conversion = converted(painted, options);
        assert_seamless(&conversion);
        let found = distance(&conversion, painted, |face, at| painted.bilinear(face, at));
        let texels = conversion.report.growth.converted_texels;
        println!("{name}, {rule}: {found}; {texels} texels for {}", painted.texel_count());
        found.root_mean_square()
    })
}

/// With samples at half texels the converted texture is the filter but for its rounding to 8 bits.
const ROUNDED: f64 = 0.35;

#[test]
fn quads_show_the_bilinear_filter() {
    let mut random = Random::new(7);
    for (name, data, noise) in [
        ("8 bits, smooth", writer::U8, 0.0),
        ("8 bits, noisy", writer::U8, 0.6),
        ("half, smooth", writer::HALF, 0.0),
    ] {
        let (positions, mut faces) = ptex::ball(4);
        ptex::turn(&mut faces, &mut random);
        let painted = Painted::new((positions, faces), data, noise, &mut random, |_| [3, 3]);
        let [default, fitted, finer, finer_fitted] = by_rule(name, &painted);
        assert!(finer < ROUNDED && finer_fitted < ROUNDED && finer < default && fitted < default);
        if noise == 0.0 {
            assert!(default < 2.0, "{default}");
        }
        if data == writer::HALF {
            assert!(finer < 0.01, "16 bits: {finer}");
        }
    }
}

#[test]
fn unequal_resolutions_and_borders_are_seamless() {
    let mut random = Random::new(8);
    let painted = Painted::new(ptex::ball(4), writer::U8, 0.5, &mut random, |face| {
        [[1, 1], [3, 2], [4, 4], [0, 3]][face % 4]
    });
    for options in
        [&[][..], &[("resolution", "area:4")][..], &[("resolution", "area:4"), ("mesh-colors", "true")][..]]
    {
        assert_seamless(&converted(&painted, options));
    }
    let (positions, mut faces) = ptex::sheet(4);
    ptex::turn(&mut faces, &mut random);
    let painted = Painted::new((positions, faces), writer::U16, 0.3, &mut random, |_| [3, 3]);
    let [.., finer, _] = by_rule("16 bits, a sheet", &painted);
    assert!(finer < 0.01, "{finer}");
}

#[test]
fn triangles_show_means_of_six() {
    let mut random = Random::new(9);
    let (positions, faces) = ptex::ball(3);
    for noise in [0.0, 0.5] {
        let faces = ptex::triangles(&faces);
        let painted = Painted::new((positions.clone(), faces), writer::U8, noise, &mut random, |_| [4, 4]);
        // Two triangles that become one quad are bilinear in it, which is what is left of the error.
        for options in [&[][..], &[("resolution", "area:4")][..]] {
            let conversion = converted(&painted, options);
            assert_seamless(&conversion);
            let found = distance(&conversion, &painted, |face, at| painted.six_means(face, at));
            let gaussian = distance(&conversion, &painted, |face, at| painted.gaussian(face, at));
            println!("triangles, noise {noise}, {options:?}: {found}; to the Gaussian {gaussian}");
            assert!(found.root_mean_square() < 0.5 + 5.0 * f64::from(noise), "{found}");
        }
    }
}

/// What is written is glTF without a trace of the Ptex file, and its mesh colors convert to the same.
#[test]
fn a_conversion_is_valid_and_its_mesh_colors_go_round() {
    let mut random = Random::new(10);
    let painted =
        Painted::new(ptex::ball(2), writer::HALF, 0.2, &mut random, |face| [(face % 3) as u8 + 1, 2]);
    let there = converted(&painted, &[("mesh-colors", "true")]);
    let file = |conversion: &Conversion, path: &str| {
        conversion.files.iter().find(|file| file.path == path).unwrap().bytes.clone()
    };
    for path in ["asset.glb", "mesh_colors.glb"] {
        validator::expect_valid(path, &file(&there, path), false);
        assert!(!file(&there, path).windows(4).any(|four| four == b"ptex"));
    }
    let upload = Upload::single("mesh_colors.glb", file(&there, "mesh_colors.glb"));
    let back = convert(&upload, &Options::default(), &Limits::default(), &Unwatched).unwrap();
    assert!(file(&back, "asset.glb") == file(&there, "asset.glb"));
    assert_eq!(there.report.channels[0].bits, 16);
}

/// Files of all data types and encodings, each with its numbers.
fn files_of_all_kinds() -> Vec<Ptex> {
    let mut files = Vec::new();
    for data in [writer::U8, writer::U16, writer::HALF, writer::FLOAT] {
        for is_triangles in [false, true] {
            let (positions, quads) = ptex::ball(2);
            let faces = if is_triangles { ptex::triangles(&quads) } else { quads };
            let log2 = |face: usize| match face % 4 {
                side if is_triangles => [side as u8; 2],
                kind => [[1, 1], [3, 2], [4, 5], [0, 3]][kind],
            };
            let random = &mut Random::new(u64::from(data));
            let mut file = Painted::new((positions, faces), data, 0.3, random, log2).file;
            for (face, stored) in [(4, Stored::Flagged), (5, Stored::Constant)] {
                let face = &mut file.faces[face];
                face.stored = stored;
                face.numbers = face.numbers[..3].repeat(face.numbers.len() / 3);
            }
            files.push(file);
        }
    }
    files
}

/// The tests' files are written from the format's description. The library that Ptex was published with reads the numbers that
/// were written.
#[test]
fn the_reference_library_reads_the_files() {
    let files = files_of_all_kinds();
    let read = openimageio::read("ptx", &files.iter().map(Ptex::bytes).collect::<Vec<_>>());
    let Some(read) = read else {
        println!("skipped: Ptex's own library (no OpenImageIO; tests/run installs it)");
        return;
    };
    for (parts, file) in read.iter().zip(&files) {
        assert_eq!(parts.len(), file.faces.len());
        for (number, (part, face)) in parts.iter().zip(&file.faces).enumerate() {
            let place = format!("data {}, face {number}, {:?}", file.data, face.stored);
            assert_eq!((part.size, part.channels), (face.log2.map(|log2| 1 << log2), 3), "{place}");
            let stored = |value: f32| match file.data {
                writer::U8 => value / 255.0,
                writer::U16 => value / 65535.0,
                writer::HALF => half::f16::from_f32(value).to_f32(),
                _ => value,
            };
            let is_same = |(found, value): (&Option<f32>, &f32)| {
                found.is_some_and(|found| (found - stored(*value)).abs() < 1e-6)
            };
            // OpenImageIO copies of a constant face's one texel as many as the face has: only the first is one.
            let is_constant = matches!(face.stored, Stored::Flagged | Stored::Constant);
            let count = if is_constant { 3 } else { face.numbers.len() };
            assert_eq!(part.values.len(), face.numbers.len(), "{place}");
            assert!(part.values.iter().zip(&face.numbers).take(count).all(is_same), "{place}");
        }
    }
}
