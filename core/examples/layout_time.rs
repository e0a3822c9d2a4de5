//! What placing the faces of a mesh takes, without anything that has to do with their colors: `cargo run --release -p
//! meshcolor-core --example layout_time -- [FACES [OBJ]]`. The mesh is a bumpy sphere of about so many triangles (100 000 without
//! a number) under a texture; it is also written to OBJ, for an atlas packer to work on the same. Prints one JSON object: processor seconds,
//! each the mean of many repeats. `docs/layout_time.py` runs it beside xatlas.

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::fmt::Write;

use meshcolor::asset::Asset;
use meshcolor::colors::level_count;
use meshcolor::image::{Image, Pixels};
use meshcolor::layout::{Coordinates, Layout, LayoutRequest, arrange};
use meshcolor::mesh::{CanvasMesh, Polygons, build, merge};
use meshcolor::read::{Limits, MemoryFiles, Upload, read};
use meshcolor::resample::{Resolution, find_cuts, pair_triangles, wanted_exponents};
use meshcolor::source::{SurfaceSource, channels};
use meshcolor::watch::Unwatched;

/// Each step is repeated for so long, or so often.
const SECONDS: f64 = 1.0;
const REPEATS_MAX: u32 = 1000;
/// Of the texture.
const SIDE_TEXELS: u32 = 2048;

/// All threads; 0 where the system does not tell.
fn processor_seconds() -> f64 {
    let Ok(threads) = std::fs::read_dir("/proc/self/task") else { return 0.0 };
    let nanoseconds = threads.flatten().filter_map(|thread| {
        let text = std::fs::read_to_string(thread.path().join("schedstat")).ok()?;
        text.split_whitespace().next()?.parse::<f64>().ok()
    });
    nanoseconds.sum::<f64>() * 1e-9
}

/// What one of many repeats takes on the average, since the clock may stand still for some milliseconds, and what the last
/// one came to.
fn timed<T>(mut work: impl FnMut() -> T) -> (f64, T) {
    let before = processor_seconds();
    let mut last = work();
    for count in 1..REPEATS_MAX {
        let seconds = processor_seconds() - before;
        if seconds > SECONDS {
            return (seconds / f64::from(count), last);
        }
        last = work();
    }
    ((processor_seconds() - before) / f64::from(REPEATS_MAX), last)
}

/// A sphere of `4 n (n - 1)` triangles, each of its points a little out or in.
fn bumpy_sphere(faces: u64) -> Result<String, std::fmt::Error> {
    let rows = ((faces as f64 / 4.0).sqrt() + 0.5).round().max(3.0) as u64;
    let columns = 2 * rows;
    let mut text = "mtllib mesh.mtl\nusemtl mesh\n".to_owned();
    for row in 0..=rows {
        for column in 0..columns {
            let (sin_u, cos_u) = (column as f64 / columns as f64 * TAU).sin_cos();
            let (sin_v, cos_v) = (row as f64 / rows as f64 * PI).sin_cos();
            let way = [sin_v * cos_u, cos_v, sin_v * sin_u];
            let waves = [[7.0, 3.0, 5.0], [-13.0, 11.0, 4.0], [23.0, -17.0, 29.0]];
            let bumps = waves.iter().zip([0.08, 0.05, 0.02]).map(|(wave, height)| {
                height * wave.iter().zip(way).map(|(w, x): (&f64, f64)| w * x).sum::<f64>().sin()
            });
            let [x, y, z] = way.map(|x| x * (1.0 + bumps.clone().sum::<f64>()));
            writeln!(text, "v {x:.6} {y:.6} {z:.6}")?;
        }
    }
    for row in 0..=rows {
        for column in 0..=columns {
            writeln!(text, "vt {:.6} {:.6}", column as f64 / columns as f64, row as f64 / rows as f64)?;
        }
    }
    let corner = |row: u64, column: u64| {
        format!("{}/{}", row * columns + column % columns + 1, row * (columns + 1) + column + 1)
    };
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b] = [corner(row, column), corner(row, column + 1)];
        let [c, d] = [corner(row + 1, column + 1), corner(row + 1, column)];
        // At each pole one side of the grid's cell is a point. Elsewhere cells are cut one way or the other, so that pairs
        // have to be looked for.
        let is_other_way = (row * 7 + column * 13) % 5 < 2;
        if row == 0 {
            writeln!(text, "f {a} {c} {d}")?;
        } else if row + 1 == rows {
            writeln!(text, "f {a} {b} {c}")?;
        } else if is_other_way {
            writeln!(text, "f {a} {b} {d}\nf {b} {c} {d}")?;
        } else {
            writeln!(text, "f {a} {b} {c}\nf {a} {c} {d}")?;
        }
    }
    Ok(text)
}

/// Soft blotches, so that no edge is a cut.
fn picture() -> Image {
    let value = |x: u32, y: u32, waves: f64| {
        let at = |place: u32| f64::from(place) / f64::from(SIDE_TEXELS) * TAU;
        (127.5 + 100.0 * (at(x) * waves).sin() * (at(y) * 4.0).sin()) as u8
    };
    let texels = (0..SIDE_TEXELS).flat_map(|y| (0..SIDE_TEXELS).map(move |x| (x, y)));
    let codes = texels.flat_map(|(x, y)| [3.0, 5.0, 7.0].map(|waves| value(x, y, waves))).collect();
    Image { width: SIDE_TEXELS, height: SIDE_TEXELS, components: 3, pixels: Pixels::U8(codes) }
}

fn canvas_of(asset: &Asset) -> CanvasMesh {
    let primitives = asset.meshes.iter().flat_map(|mesh| (0u32..).zip(&mesh.primitives));
    let mut parts: Vec<_> = primitives
        .map(|(number, primitive)| {
            let faces = primitive.faces.iter().map(|face| (face.corners, face.count));
            (number, &primitive.positions, faces)
        })
        .collect();
    build(parts.iter_mut().map(|(primitive, positions, faces)| Polygons {
        mesh: 0,
        primitive: *primitive,
        positions,
        faces,
    }))
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let face_count = arguments.next().map_or(Ok(100_000), |count| count.parse())?;
    let obj = bumpy_sphere(face_count)?;
    if let Some(path) = arguments.next() {
        std::fs::write(path, &obj)?;
    }
    let mut files = MemoryFiles::default();
    files.0.insert("mesh.obj".to_owned(), obj.into_bytes());
    files.0.insert("mesh.mtl".to_owned(), b"newmtl mesh\nmap_Kd mesh.png\n".to_vec());
    files.0.insert("mesh.png".to_owned(), meshcolor::write::png(&picture())?);
    let upload = Upload { main: "mesh.obj".to_owned(), files: Box::new(files) };
    let asset = read(&upload, &Limits::default(), &Unwatched)?;
    let channels = channels(&asset, 0, false);
    let (weld_seconds, canvas) = timed(|| canvas_of(&asset));
    let sources: Vec<_> =
        channels.iter().map(|channel| SurfaceSource::new(channel, &asset, &canvas)).collect();
    let cuts = find_cuts(&sources[0], &canvas, 8.0, &Unwatched)?;
    let mergeable: Vec<bool> = cuts.edges.iter().map(|cut| !cut).collect();
    let (pair_seconds, pairs) = timed(|| pair_triangles(&canvas, &sources, &mergeable));
    let (merge_seconds, merged) = timed(|| merge(&canvas, &pairs));
    let sources: Vec<_> = sources.iter().map(|source| source.merged(&merged)).collect();
    let canvas = merged.canvas;
    let lay_out = |coordinates: Coordinates| -> Result<(f64, Layout), Box<dyn Error>> {
        let is_elongated = coordinates == Coordinates::Indexed;
        let wanted = wanted_exponents(Resolution::Area(1.0), is_elongated, &asset, &canvas, &sources);
        let resolutions = wanted.nearest();
        let (seconds, layout) = timed(|| {
            arrange(&[LayoutRequest {
                canvas: &canvas,
                resolutions: &resolutions,
                diagonals: &vec![0; canvas.faces.len()],
                level_count: level_count(&canvas, &resolutions),
                side_limit: 16_384,
                part_side: 16_384,
                coordinates,
            }])
            .map(|mut layouts| layouts.remove(0))
        });
        Ok((seconds, layout?))
    };
    let (indexed_seconds, indexed) = lay_out(Coordinates::Indexed)?;
    let (scaled_seconds, scaled) = lay_out(Coordinates::Scaled)?;
    let size = |layout: &Layout| layout.sizes.first().copied().unwrap_or_default();
    println!(
        "{{\"faces\": {}, \"pairs\": {}, \"cut_edges\": {}, \"weld_seconds\": {weld_seconds:.4}, \"pair_seconds\": {pair_seconds:.4}, \
         \"merge_seconds\": {merge_seconds:.4}, \"indexed_seconds\": {indexed_seconds:.5}, \"indexed_size\": {:?}, \
         \"scaled_seconds\": {scaled_seconds:.5}, \"scaled_size\": {:?}}}",
        asset.meshes.iter().flat_map(|mesh| &mesh.primitives).map(|p| p.faces.len()).sum::<usize>(),
        canvas.pair_count(),
        cuts.edges.iter().filter(|cut| **cut).count(),
        size(&indexed),
        size(&scaled),
    );
    Ok(())
}
