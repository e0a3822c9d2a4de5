//! One material's journey, from its faces to its level images.

use glam::Vec3;

use crate::asset::{AlphaMode, Asset};
use crate::assign::{NormalFrames, choose_frames};
use crate::colors::{ChannelTopology, Cuts, LevelNumbering, Resolutions, level_count};
use crate::error::Result;
use crate::layout::{Coordinates, Layout, LayoutRequest, arrange};
use crate::mesh::{CanvasEdge, CanvasFace, CanvasMesh, Drawn, Polygons, Side, build, merge};
use crate::read::Limits;
use crate::resample::{find_cuts, pair_triangles, resolutions, sample};
use crate::source::tangents::corner_normals;
use crate::source::{SourceChannel, SurfaceSource, channels};
use crate::watch::{Stage, Watch};

use super::channel::{ChannelInput, FinishedChannel, Rooms, finish_channel};
use super::options::Options;
use super::progress::Progress;

/// A converted material: its layout, and its channels with what was done to each.
pub struct MaterialConversion {
    pub material: usize,
    pub canvas: CanvasMesh,
    pub resolutions: Resolutions,
    pub layout: Layout,
    /// Of a material with a normal map.
    pub frames: Option<NormalFrames>,
    pub channels: Vec<FinishedChannel>,
}

/// Converts one material; `None` where it has no texture or no face.
pub fn convert_material(
    asset: &Asset,
    material: usize,
    options: &Options,
    limits: &Limits,
    watch: &dyn Watch,
    progress: &mut Progress<'_>,
) -> Result<Option<MaterialConversion>> {
    let source_channels = channels(asset, material);
    if source_channels.is_empty() {
        return Ok(None);
    }
    let canvas = canvas_of(asset, material);
    if canvas.faces.is_empty() {
        return Ok(None);
    }
    watch.stage(Stage::Resample);
    let Paired { canvas, cuts } = pair(asset, canvas, &source_channels, options, watch)?;
    let sources = sources_on(asset, &canvas, &source_channels);
    let is_elongated = options.coordinates == Coordinates::Indexed;
    let resolutions = resolutions(options.resolution, is_elongated, asset, &canvas, &sources);
    progress.advance(0.2);
    watch.stage(Stage::Layout);
    let normals = source_channels.iter().any(SourceChannel::is_normal).then(|| normals_of(asset, &canvas));
    let request = LayoutRequest {
        canvas: &canvas,
        resolutions: &resolutions,
        diagonals: &diagonals(&canvas, &cuts),
        level_count: level_count(&canvas, &resolutions),
        side_limit: limits.texture_side,
        coordinates: options.coordinates,
    };
    let layout = arrange(&request)?;
    let normal_scale = source_channels.iter().find_map(SourceChannel::normal_scale).unwrap_or(1.0);
    let frames = normals.map(|normals| choose_frames(&canvas, &normals, normal_scale));
    let mut finished = Vec::with_capacity(sources.len());
    let mut rooms = Rooms::default();
    for (source, cuts) in sources.iter().zip(cuts) {
        let topology = ChannelTopology::new(&canvas, &resolutions, &cuts);
        let numbering = LevelNumbering::new(&canvas, &topology, &resolutions, 0);
        watch.stage(Stage::Resample);
        let samples = sample(source, &numbering, rooms.take(0), options.sampling, watch)?;
        let input = ChannelInput {
            channel: source.channel,
            resolutions: &resolutions,
            layout: &layout,
            cuts,
            frames: frames.as_ref().filter(|_| source.channel.is_normal()),
            mask_cutoff: mask_cutoff(asset, source.channel),
            mip: options.mip,
            beyond: options.beyond,
            solver: options.solver,
            range: options.range,
            rounding: options.rounding,
        };
        finished.push(finish_channel(input, numbering, samples, &mut rooms, watch)?);
        progress.advance(0.8 / sources.len() as f32);
    }
    drop(sources);
    Ok(Some(MaterialConversion { material, canvas, resolutions, layout, frames, channels: finished }))
}

fn mask_cutoff(asset: &Asset, channel: &SourceChannel<'_>) -> Option<f32> {
    match asset.materials[channel.material].alpha_mode {
        AlphaMode::Mask(cutoff) if channel.is_alpha_weighted() => Some(cutoff),
        _ => None,
    }
}

fn canvas_of(asset: &Asset, material: usize) -> CanvasMesh {
    let primitives = asset.meshes.iter().zip(0u32..).flat_map(|(mesh, mesh_number)| {
        mesh.primitives.iter().zip(0u32..).map(move |(primitive, number)| (mesh_number, number, primitive))
    });
    let mut faces: Vec<_> = primitives
        .filter(|(_, _, primitive)| primitive.material == Some(material))
        .map(|(mesh, number, primitive)| {
            let faces = primitive.faces.iter().map(|face| (face.corners, face.count));
            (mesh, number, &primitive.positions, faces)
        })
        .collect();
    build(faces.iter_mut().map(|(mesh, primitive, positions, faces)| Polygons {
        mesh: *mesh,
        primitive: *primitive,
        positions,
        faces,
    }))
}

fn sources_on<'a>(
    asset: &'a Asset,
    canvas: &CanvasMesh,
    channels: &'a [SourceChannel<'a>],
) -> Vec<SurfaceSource<'a>> {
    channels.iter().map(|channel| SurfaceSource::new(channel, asset, canvas)).collect()
}

/// A canvas with triangles in pairs, and what its channels do not join.
struct Paired {
    canvas: CanvasMesh,
    cuts: Vec<Cuts>,
}

/// Makes quads of triangles where that costs nothing and saves texels.
fn pair(
    asset: &Asset,
    canvas: CanvasMesh,
    channels: &[SourceChannel<'_>],
    options: &Options,
    watch: &dyn Watch,
) -> Result<Paired> {
    let sources = sources_on(asset, &canvas, channels);
    let cuts: Vec<Cuts> = (sources.iter())
        .map(|source| find_cuts(source, &canvas, options.cut_codes, watch))
        .collect::<Result<_>>()?;
    let normals = channels.iter().any(SourceChannel::is_normal).then(|| normals_of(asset, &canvas));
    let mergeable = mergeable(&canvas, &cuts, normals.as_deref());
    let partner = pair_triangles(&canvas, &sources, &mergeable);
    let merged = merge(&canvas, &partner);
    let kept = |cuts: &Cuts| Cuts { edges: merged.old_edges.iter().map(|&edge| cuts.edges[edge as usize]).collect() };
    let cuts = cuts.iter().map(kept).collect();
    Ok(Paired { canvas: merged.canvas, cuts })
}

/// By face and corner.
fn normals_of(asset: &Asset, canvas: &CanvasMesh) -> Vec<[Vec3; 4]> {
    let of_face = |face: &CanvasFace| {
        let of_drawn = |drawn: &Drawn| {
            let primitive = &asset.meshes[face.mesh as usize].primitives[drawn.primitive as usize];
            let normals = corner_normals(primitive, &primitive.faces[drawn.face as usize]);
            drawn.corners.map(|corner| normals[usize::from(corner)])
        };
        let [[a, b, c], [_, _, d]] = face.drawn.each_ref().map(of_drawn);
        [a, b, c, d]
    };
    canvas.faces.iter().map(of_face).collect()
}

/// Edges across which two triangles may become one quad: no channel cuts them, and with a normal map both
/// sides have the same normals there, since the texels of the diagonal are stored once.
fn mergeable(canvas: &CanvasMesh, cuts: &[Cuts], normals: Option<&[[Vec3; 4]]>) -> Vec<bool> {
    let one = |(number, edge): (usize, &CanvasEdge)| {
        let &[a, b] = canvas.sides(edge) else { return false };
        let same_normals = |normals: &[[Vec3; 4]]| {
            (0..2).all(|end| {
                let normal = |side: Side| normals[side.face as usize][canvas.corner_at_end(side, end)];
                normal(a) == normal(b)
            })
        };
        !cuts.iter().any(|cuts| cuts.edges[number]) && normals.is_none_or(same_normals)
    };
    canvas.edges.iter().enumerate().map(one).collect()
}

/// The edge that a triangle would put on its diagonal if it stays alone: one with nothing on the other side
/// where there is one, so that the border texels bind nobody.
fn diagonals(canvas: &CanvasMesh, cuts: &[Cuts]) -> Vec<u8> {
    let burden = |edge: u32| {
        let edge = edge as usize;
        if canvas.sides(&canvas.edges[edge]).len() == 1 {
            return 0;
        }
        cuts.iter().filter(|cuts| !cuts.edges[edge]).count()
    };
    let least =
        |face: &CanvasFace| (0..face.count).min_by_key(|&k| burden(face.edges[usize::from(k)])).unwrap_or(0);
    canvas.faces.iter().map(least).collect()
}
