//! A material before anything of it is stored: its faces, triangles in pairs, and what its channels do not join.

use glam::Vec3;

use crate::asset::Asset;
use crate::colors::Cuts;
use crate::error::Result;
use crate::mesh::{CanvasEdge, CanvasFace, CanvasMesh, Drawn, Polygons, Side, build, merge};
use crate::resample::{find_cuts, pair_triangles};
use crate::source::tangents::corner_normals;
use crate::source::{SourceChannel, SurfaceSource};
use crate::watch::Watch;

use super::form::ChannelForm;
use super::options::Options;
use super::painted::{Painted, Restored, restore};

pub struct Prepared<'a> {
    pub material: usize,
    pub canvas: CanvasMesh,
    pub channels: Vec<ChannelForm>,
    pub content: Content<'a>,
    /// By channel.
    pub cuts: Vec<Cuts>,
    /// By canvas edge: whether its two faces could store the same there.
    pub joinable: Vec<bool>,
    /// By face and corner; of a material with a normal map.
    pub normals: Option<Vec<[Vec3; 4]>>,
}

/// Where samples come from.
pub enum Content<'a> {
    /// By channel.
    Textures(Vec<SurfaceSource<'a>>),
    Painted(Painted<'a>),
}

/// `None` where the material has no face, and neither textures nor mesh colors.
///
/// # Errors
/// `Canceled`; `InvalidModel` where mesh colors do not fit their faces.
pub fn prepare<'a>(
    asset: &'a Asset,
    material: usize,
    channels: &'a [SourceChannel<'a>],
    options: &Options,
    watch: &dyn Watch,
) -> Result<Option<Prepared<'a>>> {
    let colors = asset.materials[material].mesh_colors.as_ref();
    if channels.is_empty() && colors.is_none() {
        return Ok(None);
    }
    let canvas = canvas_of(asset, material);
    if canvas.faces.is_empty() {
        return Ok(None);
    }
    if let Some(colors) = colors {
        let Restored { canvas, cuts, painted } = restore(canvas, colors, !channels.is_empty())
            .map_err(|error| error.at(format!("/materials/{material}")))?;
        let forms = colors.channels.iter().map(|channel| ChannelForm::of_colors(asset, material, channel));
        let content = Content::Painted(painted);
        return Ok(Some(Prepared::new(asset, (material, canvas), forms.collect(), cuts, content)));
    }
    let sources: Vec<SurfaceSource<'a>> =
        channels.iter().map(|channel| SurfaceSource::new(channel, asset, &canvas)).collect();
    let cuts: Vec<Cuts> = (sources.iter())
        .map(|source| find_cuts(source, &canvas, options.cut_codes, watch))
        .collect::<Result<_>>()?;
    let has_normals = channels.iter().any(SourceChannel::is_normal);
    let normals = has_normals.then(|| normals_of(asset, &canvas));
    let pairs = pair_triangles(&canvas, &sources, &joinable(&canvas, &cuts, normals.as_deref()));
    let merged = merge(&canvas, &pairs);
    let sources = sources.iter().map(|source| source.merged(&merged)).collect();
    let kept = |cuts: &Cuts| merged.old_edges.iter().map(|&edge| cuts.edges[edge as usize]).collect();
    let cuts: Vec<Cuts> = cuts.iter().map(|cuts| Cuts { edges: kept(cuts) }).collect();
    let forms = channels.iter().map(ChannelForm::of_source).collect();
    let content = Content::Textures(sources);
    Ok(Some(Prepared::new(asset, (material, merged.canvas), forms, cuts, content)))
}

impl<'a> Prepared<'a> {
    fn new(
        asset: &Asset,
        (material, canvas): (usize, CanvasMesh),
        channels: Vec<ChannelForm>,
        cuts: Vec<Cuts>,
        content: Content<'a>,
    ) -> Self {
        let has_normals = channels.iter().any(|form| form.kind.is_normal());
        let normals = has_normals.then(|| normals_of(asset, &canvas));
        let joinable = joinable(&canvas, &cuts, normals.as_deref());
        Self { material, canvas, channels, content, cuts, joinable, normals }
    }
}

/// The faces of a material, over all meshes, as the asset has them.
pub fn canvas_of(asset: &Asset, material: usize) -> CanvasMesh {
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

/// By face and corner.
pub fn normals_of(asset: &Asset, canvas: &CanvasMesh) -> Vec<[Vec3; 4]> {
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

/// Edges whose texels may be stored once, in a pair of triangles or in a larger block: no channel cuts them, and with
/// a normal map both sides have the same normals there.
pub fn joinable(canvas: &CanvasMesh, cuts: &[Cuts], normals: Option<&[[Vec3; 4]]>) -> Vec<bool> {
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
