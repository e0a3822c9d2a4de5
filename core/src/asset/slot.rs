//! What a material's textures are for: the slots of core glTF, and attributes that somebody named.

use std::fmt;

/// The glTF extension of converted textures, of the primitives that read them, and of what materials have beyond core
/// slots.
pub const TEXTURE_EXTENSION: &str = "MCT_mesh_color_texture";

/// A texture slot of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Slot {
    BaseColor,
    MetallicRoughness,
    Normal,
    Occlusion,
    Emissive,
    /// Data that core glTF has no slot for, such as thickness or baked light.
    Attribute(AttributeName),
}

impl Slot {
    /// The five texture slots of core glTF 2.0.
    pub const CORE: [Slot; 5] =
        [Slot::BaseColor, Slot::MetallicRoughness, Slot::Normal, Slot::Occlusion, Slot::Emissive];

    /// The property that holds this slot, at the end of [`Slot::path`].
    pub fn gltf_name(&self) -> &str {
        match self {
            Slot::BaseColor => "baseColorTexture",
            Slot::MetallicRoughness => "metallicRoughnessTexture",
            Slot::Normal => "normalTexture",
            Slot::Occlusion => "occlusionTexture",
            Slot::Emissive => "emissiveTexture",
            Slot::Attribute(name) => name.property(),
        }
    }

    /// The slot that a property holds; `None` where it is neither a core slot nor `NAMETexture` with an attribute's name.
    pub fn of_gltf_name(name: &str) -> Option<Self> {
        Self::named(name.strip_suffix(SUFFIX)?)
    }

    /// The core slot or the attribute of that name: `baseColor`, `thickness`.
    pub fn named(name: &str) -> Option<Self> {
        let core = Self::CORE.into_iter().find(|slot| slot.gltf_name().strip_suffix(SUFFIX) == Some(name));
        core.or_else(|| AttributeName::new(name).map(Slot::Attribute))
    }

    /// Where a glTF material has the slot's texture info: property names from the outermost on.
    pub fn path(&self) -> Vec<&str> {
        match self {
            Slot::BaseColor | Slot::MetallicRoughness => vec!["pbrMetallicRoughness", self.gltf_name()],
            Slot::Normal | Slot::Occlusion | Slot::Emissive => vec![self.gltf_name()],
            Slot::Attribute(_) => vec!["extensions", TEXTURE_EXTENSION, "channels", self.gltf_name()],
        }
    }

    /// Whether the slot's texture is sRGB-encoded color.
    pub fn is_color(&self) -> bool {
        matches!(self, Slot::BaseColor | Slot::Emissive)
    }

    pub fn is_attribute(&self) -> bool {
        matches!(self, Slot::Attribute(_))
    }
}

/// What stands behind a name in glTF's properties.
const SUFFIX: &str = "Texture";
const SUFFIX_BYTES: usize = SUFFIX.len();

/// The name of an attribute: 1 to 32 ASCII letters, digits, `_` and `-`, a letter first, and none of the core slots'.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct AttributeName {
    /// The name and [`SUFFIX`], then zeros.
    property: [u8; Self::BYTES_MAX + SUFFIX_BYTES],
    length: u8,
}

impl AttributeName {
    pub const BYTES_MAX: usize = 32;
    /// What a name may be, in words.
    pub const RULE: &str = "1 to 32 letters, digits, `_` and `-`, a letter first, and not baseColor, metallicRoughness, normal, \
                            occlusion or emissive";

    /// `None` where the name breaks [`AttributeName::RULE`].
    pub fn new(name: &str) -> Option<Self> {
        let is_known = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
        let is_core = |slot: &Slot| slot.gltf_name().strip_suffix(SUFFIX) == Some(name);
        let is_sound = name.len() <= Self::BYTES_MAX
            && name.bytes().all(is_known)
            && name.starts_with(|first: char| first.is_ascii_alphabetic())
            && !Slot::CORE.iter().any(is_core);
        is_sound.then(|| {
            let mut property = [0; Self::BYTES_MAX + SUFFIX_BYTES];
            property[..name.len()].copy_from_slice(name.as_bytes());
            property[name.len()..][..SUFFIX_BYTES].copy_from_slice(SUFFIX.as_bytes());
            Self { property, length: name.len() as u8 }
        })
    }

    pub fn as_str(&self) -> &str {
        &self.property()[..usize::from(self.length)]
    }

    fn property(&self) -> &str {
        // Nothing but ASCII was let in.
        str::from_utf8(&self.property[..usize::from(self.length) + SUFFIX_BYTES]).unwrap_or(SUFFIX)
    }
}

impl fmt::Debug for AttributeName {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_property_names_its_slot() {
        let thickness = AttributeName::new("thickness-2_b").unwrap();
        assert_eq!(
            (thickness.as_str(), format!("{thickness:?}").as_str()),
            ("thickness-2_b", "thickness-2_b")
        );
        for slot in Slot::CORE.into_iter().chain([Slot::Attribute(thickness)]) {
            assert_eq!(Slot::of_gltf_name(slot.gltf_name()), Some(slot));
            assert_eq!(slot.path().last(), Some(&slot.gltf_name()));
        }
        assert_eq!(
            Slot::Attribute(thickness).path(),
            ["extensions", "MCT_mesh_color_texture", "channels", "thickness-2_bTexture"]
        );
    }

    #[test]
    fn names_are_short_plain_and_not_a_core_slots() {
        let longest = "n".repeat(AttributeName::BYTES_MAX);
        assert_eq!(AttributeName::new(&longest).unwrap().as_str(), longest);
        let too_long = format!("{longest}n");
        for name in ["", &too_long, "1st", "_wear", "a b", "höhe", "a/b", "a.b", "normal", "baseColor"] {
            assert_eq!(AttributeName::new(name), None, "{name}");
        }
        for property in ["thickness", "Texture", "normal", "1Texture"] {
            assert_eq!(Slot::of_gltf_name(property), None, "{property}");
        }
    }
}
