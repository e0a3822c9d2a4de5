//! The color of one fragment: the CPU twin of the fragment stage of `preview.wgsl`.

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles};
use meshcolor::asset::{AlphaMode, Slot};
use meshcolor::filter::Footprint;
use meshcolor::math::transfer::srgb_to_linear;
use meshcolor::source::painted::PaintedSource;

use super::raster::Weights;
use super::sample::{sample_mesh_colors, sample_mip_maps};
use crate::preview::scene::Filter;
use crate::preview::scene::geometry::{Batch, NORMAL_AT};
use crate::preview::scene::surface::{Coordinate, Look};
use crate::preview::scene::texture::Texture;
use crate::preview::shade::{Shaded, lit, mapped_normal, source_lambda};
use crate::twins::indexed::{MctBlockPlace, mct_indexed_lambda, mct_indexed_place};
use crate::twins::{mct_lambda, mct_place};

/// What a flat picture shows where a material has no texture in the channel shown.
pub const ABSENT: f32 = 0.03;

/// Where a fragment lies in its triangle.
pub struct Fragment<'a> {
    pub batch: &'a Batch,
    /// Number of the triangle in its batch.
    pub triangle: usize,
    pub corners: [&'a [f32]; 3],
    pub is_front: bool,
    pub weights: Weights,
    pub textures: &'a [Texture<'a>],
    pub painted: &'a [PaintedSource<'a>],
    pub filter: Filter,
}

impl Fragment<'_> {
    fn mix<const N: usize>(&self, at: usize, weights: Vec3) -> [f32; N] {
        std::array::from_fn(|i| {
            self.corners[0][at + i] * weights.x
                + self.corners[1][at + i] * weights.y
                + self.corners[2][at + i] * weights.z
        })
    }

    /// The filtered value of a slot; `None` where the surface has no texture there.
    fn sample(&self, slot: Slot) -> Option<Vec4> {
        if let Some(source) = self.batch.surface.painted {
            return self.sample_painted(&self.painted[source], slot);
        }
        let binding = self.batch.surface.binding(slot)?;
        let texture = &self.textures[binding.texture];
        let Weights { at, dx, dy } = self.weights;
        match (binding.coordinate, self.batch.layout.mesh) {
            (Coordinate::Mesh, Some(place)) => {
                let coordinate = Vec4::from_array(self.mix(place, at));
                let [dx, dy] = [dx, dy].map(|weights| Vec2::from_array(self.mix(place, weights)));
                Some(self.sample_mesh(texture, coordinate, [dx, dy], place))
            }
            (Coordinate::Mesh, None) => None,
            (Coordinate::Uv { set, wrap }, _) => {
                let place = self.batch.layout.uv + 2 * set;
                let [uv, dx, dy] = [at, dx, dy].map(|weights| Vec2::from_array(self.mix(place, weights)));
                let finest = texture.level(0);
                let size = Vec2::new(finest.width as f32, finest.height as f32);
                Some(sample_mip_maps(texture, wrap, uv, source_lambda(dx, dy, size), self.filter))
            }
        }
    }

    /// What the filters of mesh colors make of a slot's samples; `None` where there are none for it.
    fn sample_painted(&self, source: &PaintedSource<'_>, slot: Slot) -> Option<Vec4> {
        let slot = if slot == Slot::BaseColor { self.batch.surface.base } else { slot };
        let (colors, place) = (&source.channel(slot)?.colors, self.batch.layout.painted?);
        let face = self.batch.painted.face(self.triangle);
        let Weights { at, dx, dy } = self.weights;
        let [at, dx, dy] = [at, dx, dy].map(|weights| Vec2::from_array(self.mix(place, weights)));
        Some(match self.filter {
            Filter::Level(level) => colors.linear(face, at, level as usize),
            Filter::Trilinear => colors.mip_mapped(face, at, Footprint { axes: [dx, dy] }),
        })
    }

    /// The same by mesh coordinate, which stands at `place` of a record; `changes` are those of its first half.
    fn sample_mesh(&self, texture: &Texture<'_>, coordinate: Vec4, changes: [Vec2; 2], place: usize) -> Vec4 {
        let [dx, dy] = changes;
        let Some(table) = &self.batch.table else {
            let place = |level| mct_place(coordinate, level);
            return sample_mesh_colors(texture, place, mct_lambda(dx, dy), self.filter);
        };
        // Flat, as on a GPU.
        let [number, class] = [2, 3].map(|at| self.corners[0][place + at] as u32);
        let at = MctBlockPlace { local: coordinate.xy(), number, shape: table.classes[class as usize] };
        let place = |level| mct_indexed_place(at, table.grid(class as usize, level), level);
        sample_mesh_colors(texture, place, mct_indexed_lambda(dx, dy, at.shape), self.filter)
    }

    /// Unit length, toward the viewer, with the normal map.
    fn normal(&self) -> Vec3 {
        let facing = if self.is_front { 1.0 } else { -1.0 };
        let normal = Vec3::from_array(self.mix(NORMAL_AT, self.weights.at)).normalize_or(Vec3::Z);
        let stored = self.sample(Slot::Normal);
        if let (Some(_), Some(stored)) = (self.batch.surface.painted, stored) {
            // In the mesh's space, and shorter where samples part; where they cancel out the surface shows.
            let stored = stored.truncate().try_normalize();
            return facing * stored.map_or(normal, |stored| self.batch.painted.normal(self.triangle, stored));
        }
        let (Some(stored), Some(place)) = (stored, self.batch.layout.tangent) else {
            return normal * facing;
        };
        let tangent = Vec4::from_array(self.mix(place, self.weights.at));
        let direction = tangent.truncate().normalize_or(Vec3::X);
        let handedness = if tangent.w < 0.0 { -1.0 } else { 1.0 };
        facing
            * mapped_normal(stored.truncate(), self.batch.surface.normal_scale, normal, direction, handedness)
    }

    /// Linear color and alpha; `None` where the alpha test fails.
    pub fn color(&self, look: Look) -> Option<Vec4> {
        let surface = &self.batch.surface;
        let texel = self.sample(Slot::BaseColor);
        let tint =
            self.batch.layout.color.map_or(Vec4::ONE, |at| Vec4::from_array(self.mix(at, self.weights.at)));
        let base = texel.unwrap_or(Vec4::ONE) * tint * surface.base_color_factor;
        if let AlphaMode::Mask(cutoff) = surface.alpha_mode
            && base.w < cutoff
        {
            return None;
        }
        let alpha = if surface.alpha_mode == AlphaMode::Blend { base.w.clamp(0.0, 1.0) } else { 1.0 };
        let color = match look {
            Look::Lit => lit(&self.shaded(base.truncate())),
            Look::Flat(Slot::BaseColor | Slot::Attribute(_)) => base.truncate(),
            Look::Flat(slot) => self.flat(slot),
        };
        Some(color.clamp(Vec3::ZERO, Vec3::ONE).extend(alpha))
    }

    /// A channel as it is stored: codes of data channels come out as the same codes of the picture.
    fn flat(&self, slot: Slot) -> Vec3 {
        let Some(value) = self.sample(slot) else { return Vec3::splat(ABSENT) };
        let shown = match slot {
            Slot::Emissive | Slot::BaseColor | Slot::Attribute(_) => return value.truncate(),
            Slot::Normal => self.normal() * 0.5 + 0.5,
            Slot::Occlusion => Vec3::splat(value.x),
            Slot::MetallicRoughness => value.truncate(),
        };
        Vec3::from_array(shown.to_array().map(srgb_to_linear))
    }

    fn shaded(&self, base_color: Vec3) -> Shaded {
        let surface = &self.batch.surface;
        let metallic_roughness = self.sample(Slot::MetallicRoughness).unwrap_or(Vec4::ONE);
        let occlusion = self.sample(Slot::Occlusion).map_or(1.0, |value| value.x);
        let emissive = self.sample(Slot::Emissive).map_or(Vec3::ONE, |value| value.truncate());
        let position = Vec3::from_array(self.mix(0, self.weights.at));
        Shaded {
            base_color,
            metallic: metallic_roughness.z * surface.metallic_factor,
            roughness: metallic_roughness.y * surface.roughness_factor,
            occlusion: 1.0 + surface.occlusion_strength * (occlusion - 1.0),
            emissive: emissive * surface.emissive_factor,
            normal: self.normal(),
            eye: (-position).normalize_or(Vec3::Z),
        }
    }
}
