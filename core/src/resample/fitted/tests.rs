use glam::{Vec2, Vec3, Vec4};

use super::super::mass::Mass;
use super::{Borders, Fit, cell_areas, fit};
use crate::asset::{AlphaMode, Asset, Face, Material, Mesh, Primitive, Slot, TextureRef, UvTransform};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions, Shape};
use crate::image::{Image, Pixels, Wrap};
use crate::mesh::{CanvasMesh, Polygons, build};
use crate::resample::{Sampling, sample};
use crate::source::{SurfaceSource, channels};
use crate::watch::Unwatched;

/// Two triangles and a quad in a row, whose exponents differ: edges with steps of 2 and of 4.
const EXPONENTS: [u8; 3] = [2, 3, 1];

/// Texture coordinates are affine in the positions, and the quad is a parallelogram: else its two drawn
/// triangles show what no bilinear cell can. Data, or base color with alpha.
fn patch(image: Image, slot: Slot) -> Asset {
    let positions = [[0.0, 0.0], [1.0, 0.1], [0.1, 1.0], [1.3, 1.0], [0.0, 2.0], [1.2, 2.0]].map(Vec2::from);
    let primitive = Primitive {
        material: Some(0),
        positions: positions.map(|at| at.extend(0.0)).to_vec(),
        texcoords: vec![positions.map(|at| at * 0.35 + 0.1).to_vec()],
        faces: vec![
            Face::triangle([0, 1, 2]),
            Face::triangle([1, 3, 2]),
            Face { corners: [2, 3, 5, 4], count: 4 },
        ],
        ..Primitive::default()
    };
    let mut material = Material { alpha_mode: AlphaMode::Blend, ..Material::default() };
    material.slots.insert(
        slot,
        TextureRef { image: 0, wrap: Wrap::default(), texcoord: 0, transform: UvTransform::default() },
    );
    Asset {
        images: vec![image],
        materials: vec![material],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        ..Asset::default()
    }
}

fn canvas_of(asset: &Asset) -> CanvasMesh {
    let primitive = &asset.meshes[0].primitives[0];
    let mut faces = primitive.faces.iter().map(|face| (face.corners, face.count));
    build([Polygons { mesh: 0, primitive: 0, positions: &primitive.positions, faces: &mut faces }])
}

fn with_numbering<T>(
    asset: &Asset,
    exponents: [u8; 3],
    run: impl FnOnce(&SurfaceSource<'_>, &LevelNumbering<'_>) -> T,
) -> T {
    let canvas = canvas_of(asset);
    let channels = channels(asset, 0, false);
    let source = SurfaceSource::new(&channels[0], asset, &canvas);
    let resolutions = Resolutions::uniform(exponents.iter().copied());
    let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
    run(&source, &LevelNumbering::new(&canvas, &topology, &resolutions, 0))
}

fn wide(code: impl Fn(u32, u32) -> u16) -> Image {
    let pixels = (0..256).flat_map(|k| [code(k % 16, k / 16); 3]).collect();
    Image { width: 16, height: 16, components: 3, pixels: Pixels::U16(pixels) }
}

fn noise(x: u32, y: u32) -> u16 {
    ((x * 7919 + y * 104_729 + x * y * 613) % 65_536) as u16
}

/// Points of a face's cell with their hats, of a rule that is exact for products of two hats.
fn cells(numbering: &LevelNumbering<'_>, face: usize, mut visit: impl FnMut(&[((u32, u32), f32)], f32)) {
    let Shape { is_triangle, segments: [n, m] } = numbering.shape(face);
    for (i, j) in (0..m).flat_map(|j| (0..n).map(move |i| (i, j))) {
        let corners = [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)];
        let mut triangle = |numbers: [usize; 3]| {
            for [a, b] in [[0, 1], [1, 2], [2, 0]] {
                visit(&[(corners[numbers[a]], 0.5), (corners[numbers[b]], 0.5)], 1.0 / 6.0);
            }
        };
        if is_triangle {
            if i + j < n {
                triangle([0, 1, 2]);
            }
            if i + j + 1 < n {
                triangle([3, 2, 1]);
            }
        } else {
            // Simpson's rule along both axes.
            let rule = [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)];
            for ((x, of_x), (y, of_y)) in rule.iter().flat_map(|x| rule.map(|y| (*x, y))) {
                let hats = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
                let hats: Vec<_> = corners.into_iter().zip(hats).collect();
                visit(&hats, of_x * of_y);
            }
        }
    }
}

/// The product agrees with integrals of reconstructions, point by point, on coarse and fine edges.
#[test]
fn the_mass_matrix_is_that_of_the_reconstruction() {
    let asset = patch(wide(noise), Slot::MetallicRoughness);
    with_numbering(&asset, EXPONENTS, |_, numbering| {
        let count = numbering.sample_count();
        let values: Vec<Vec4> =
            (0..count as u32).map(|k| Vec4::splat(f32::from(noise(k, k / 7)) / 65_535.0)).collect();
        let areas = cell_areas(numbering);
        let mut wanted = vec![0.0f64; count];
        for (face, area) in areas.iter().enumerate() {
            cells(numbering, face, |hats, share| {
                let taps = || hats.iter().map(|&((i, j), hat)| (numbering.tap(face, i, j), hat));
                let shown: f32 = taps().map(|(tap, hat)| tap.value(&values).x * hat).sum();
                for (tap, hat) in taps() {
                    let part = f64::from(shown * hat * share * area);
                    wanted[tap.samples[0] as usize] += part * f64::from(1.0 - tap.second);
                    wanted[tap.samples[1] as usize] += part * f64::from(tap.second);
                }
            });
        }
        let mass = Mass { numbering, cell_areas: &areas, color_weights: None };
        let mut product = vec![Vec4::ZERO; count];
        mass.multiply(&values, &mut product, &mut Borders::new(numbering), &Unwatched).unwrap();
        for (found, wanted) in product.iter().zip(&wanted) {
            assert!((f64::from(found.x) - wanted).abs() < 1e-6, "{found}, {wanted}");
        }
    });
}

/// Invariant 6: what the samples can show comes back, from where the fit starts or from nothing.
#[test]
fn a_representable_source_comes_back() {
    let asset = patch(wide(|x, y| (4000 + 2000 * x + 1500 * y) as u16), Slot::MetallicRoughness);
    for exponents in [EXPONENTS, [6, 6, 6], [0, 0, 0]] {
        with_numbering(&asset, exponents, |source, numbering| {
            let point = sample(source, numbering, Vec::new(), Sampling::Point, &Unwatched).unwrap().values;
            let fitted = sample(source, numbering, Vec::new(), Sampling::Fitted, &Unwatched).unwrap();
            assert!(fitted.fit.unwrap().is_converged());
            let nothing = vec![Vec4::ZERO; point.len()];
            let (from_nothing, fit) = fit(source, numbering, nothing, &Unwatched).unwrap();
            assert!(fit.step_count > 0 && fit.is_converged() && fit.clamped_count == 0, "{fit:?}");
            for (k, wanted) in point.iter().enumerate() {
                assert!((fitted.values[k] - *wanted).abs().max_element() < 1e-6, "{exponents:?} {k}");
                assert!((from_nothing[k] - *wanted).abs().max_element() < 1e-5, "{exponents:?} {k}");
            }
        });
    }
}

/// Squared error of the reconstruction over the surface.
fn error(source: &SurfaceSource<'_>, numbering: &LevelNumbering<'_>, values: &[Vec4]) -> f64 {
    let mut sum = 0.0;
    for (face, area) in cell_areas(numbering).into_iter().enumerate() {
        let Shape { is_triangle, segments: [n, m] } = numbering.shape(face);
        for (a, b) in (0..8 * m).flat_map(|b| (0..8 * n).map(move |a| (a, b))) {
            let [x, y] = [a, b].map(|k| (k as f32 + 0.4) / 8.0);
            if is_triangle && x + y > n as f32 {
                continue;
            }
            let (i, j) = (x as u32, y as u32);
            let (fx, fy) = (x.fract(), y.fract());
            let at = |di: u32, dj: u32| numbering.tap(face, i + di, j + dj).value(values);
            let shown = if !is_triangle {
                at(0, 0).lerp(at(1, 0), fx).lerp(at(0, 1).lerp(at(1, 1), fx), fy)
            } else if fx + fy <= 1.0 {
                at(0, 0) * (1.0 - fx - fy) + at(1, 0) * fx + at(0, 1) * fy
            } else {
                at(1, 1) * (fx + fy - 1.0) + at(0, 1) * (1.0 - fx) + at(1, 0) * (1.0 - fy)
            };
            let wanted = source.at(numbering.canvas, face, x / n as f32, y / m as f32);
            sum += f64::from((shown - wanted).truncate().length_squared() * area);
        }
    }
    sum
}

#[test]
fn fitted_is_nearest_and_in_range() {
    let checker = wide(|x, y| if (x / 2 + y / 2) % 2 == 0 { 0 } else { 65_535 });
    for image in [wide(noise), checker] {
        let asset = patch(image, Slot::MetallicRoughness);
        with_numbering(&asset, EXPONENTS, |source, numbering| {
            let of = |rung| sample(source, numbering, Vec::new(), rung, &Unwatched).unwrap();
            let [point, filtered, fitted] =
                [Sampling::Point, Sampling::Filtered(Some(4)), Sampling::Fitted].map(of);
            let [a, b, c] = [&point, &filtered, &fitted].map(|s| error(source, numbering, &s.values));
            assert!(c < 0.95 * a.min(b), "point {a}, filtered {b}, fitted {c}");
            assert!(fitted.values.iter().all(|v| v.min_element() >= 0.0 && v.max_element() <= 1.0));
        });
    }
}

#[test]
fn what_is_transparent_does_not_tint_a_fit() {
    let pixels =
        (0..256u32).flat_map(|k| if k % 16 < 6 { [255, 0, 0, 0] } else { [40, 90, 90, 255] }).collect();
    let image = Image { width: 16, height: 16, components: 4, pixels: Pixels::U8(pixels) };
    let asset = patch(image, Slot::BaseColor);
    with_numbering(&asset, [3, 3, 3], |source, numbering| {
        let fitted = sample(source, numbering, Vec::new(), Sampling::Fitted, &Unwatched).unwrap();
        assert!(fitted.fit.is_some_and(|fit: Fit| fit.is_converged()));
        let opaque = crate::math::transfer::srgb_to_linear(40.0 / 255.0);
        let shown: Vec<_> = fitted.values.iter().filter(|value| value.w > 0.99).collect();
        assert!(shown.len() > 20);
        let worst = shown.iter().map(|value| (value.x - opaque).abs()).fold(0.0, f32::max);
        assert!(worst < 0.05, "{worst}");
    });
}

#[test]
fn threads_do_not_change_a_bit() {
    let asset = patch(wide(noise), Slot::MetallicRoughness);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            with_numbering(&asset, [6, 5, 6], |source, numbering| {
                sample(source, numbering, Vec::new(), Sampling::Fitted, &Unwatched).unwrap().values
            })
        })
    };
    let one = with(1);
    assert!(one == with(3) && one.iter().any(|value| value.truncate() != Vec3::ZERO));
}
