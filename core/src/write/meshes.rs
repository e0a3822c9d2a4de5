//! One mesh: which converted pieces stand in which of its primitives.
//!
//! The first piece of a source's primitive takes its place; pieces of further parts are appended. Pieces of materials
//! that became one are joined where nothing but geometry differs, and places that nothing is left for are removed.

use std::collections::BTreeSet;

use crate::asset::Asset;
use crate::error::{Error, Result};
use crate::finished::{Finished, FinishedPrimitive};
use crate::watch::{Watch, check};

use super::draft::Draft;
use super::geometry::Member;
use super::materials::Materials;
use super::ngons;
use super::primitives::{Group, Target, rest_of};
use super::united;

/// A mesh to write; `pieces` are its converted ones with triangles, in order of primitive and part.
pub struct MeshTarget<'a> {
    pub asset: &'a Asset,
    pub finished: &'a Finished,
    pub mesh: usize,
    pub pieces: &'a [&'a FinishedPrimitive],
}

impl<'a> MeshTarget<'a> {
    /// Returns the number of vertices.
    pub fn write(&self, draft: &mut Draft<'_>, materials: &mut Materials, watch: &dyn Watch) -> Result<u64> {
        let Self { asset, finished, mesh, pieces } = *self;
        let source = &asset.meshes[mesh];
        ngons::mark_primitives(draft, mesh);
        let borders = united::borders(source, &materials.united, pieces);
        let border = |piece: &FinishedPrimitive| {
            borders.get(&(piece.primitive, piece.part)).map_or(&[][..], Vec::as_slice)
        };
        let groups = self.groups(draft, materials, border)?;
        let converted: BTreeSet<usize> = pieces.iter().map(|piece| piece.primitive).collect();
        let mut empty = converted.clone();
        let mut groups = groups.into_iter().peekable();
        let mut vertex_count = 0;
        for (primitive, plain) in source.primitives.iter().enumerate() {
            check(watch)?;
            let target = Target { asset, finished, mesh, primitive };
            if !converted.contains(&primitive) {
                target.write_source(draft, materials)?;
                vertex_count += plain.positions.len();
            }
            while let Some((_, group)) = groups.next_if(|(first, _)| *first == primitive) {
                let slot = if empty.remove(&primitive) {
                    primitive
                } else {
                    source.primitives.len().max(draft.primitives(mesh).len())
                };
                vertex_count += target.write_converted(draft, materials, &group, slot)?;
            }
        }
        for &primitive in empty.iter().rev() {
            draft.primitives(mesh).remove(primitive);
        }
        Ok(vertex_count as u64)
    }

    /// The pieces by the primitives that they will stand in, each with the source's primitive of the first.
    fn groups(
        &self,
        draft: &mut Draft<'_>,
        materials: &Materials,
        border: impl Fn(&FinishedPrimitive) -> &'a [u8],
    ) -> Result<Vec<(usize, Group<'a>)>> {
        let mut groups: Vec<(usize, Group<'a>)> = Vec::with_capacity(self.pieces.len());
        for &piece in self.pieces {
            let converted = materials.converted(piece.material, piece.part).cloned().ok_or_else(|| {
                Error::internal("a converted primitive's material has no converted texture")
                    .at(format!("/meshes/{}/primitives/{}", self.mesh, piece.primitive))
            })?;
            let source = &self.asset.meshes[self.mesh].primitives[piece.primitive];
            let member = Member { source, piece, converted, border: border(piece) };
            let rest = rest_of(draft.primitive(self.mesh, piece.primitive));
            let is_united = materials.united.contains(piece.material);
            let mut known = groups.iter_mut().filter(|_| is_united).map(|(_, group)| group);
            match known.find(|group| group.takes(&member, &rest)) {
                Some(group) => group.members.push(member),
                None => groups.push((piece.primitive, Group { members: vec![member], rest })),
            }
        }
        Ok(groups)
    }
}
