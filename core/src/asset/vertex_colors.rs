//! Vertex colors: what `COLOR_0` holds, as numbers.

use glam::Vec4;

use super::{Attribute, Primitive};

/// The attribute that multiplies a material's base color.
pub const VERTEX_COLORS: &str = "COLOR_0";

impl Primitive {
    /// The linear colors of the vertices with their alpha (1 where there is none), all within [0, 1]: what lies outside of it, which
    /// no texture slot holds, is the nearest that is inside. `None` without `COLOR_0`, and where it is of a type that glTF does
    /// not allow.
    pub fn vertex_colors(&self) -> Option<Vec<Vec4>> {
        let (attribute, component) = self.color_attribute()?;
        let size = component.byte_count();
        let color = |element: &[u8]| {
            let mut color = Vec4::ONE;
            for (k, bytes) in element.chunks_exact(size).take(4).enumerate() {
                let value = component.value(bytes);
                color[k] = if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) };
            }
            color
        };
        Some(attribute.bytes.chunks_exact(attribute.element_bytes).map(color).collect())
    }

    pub fn has_vertex_colors(&self) -> bool {
        self.color_attribute().is_some()
    }

    /// Whether the vertex colors have an alpha.
    pub fn has_vertex_alpha(&self) -> bool {
        self.color_attribute().is_some_and(|(attribute, _)| attribute.kind == "VEC4")
    }

    /// How many vertices have a color that is not within [0, 1].
    pub fn unbounded_color_count(&self) -> u64 {
        let Some((attribute, Component::Float)) = self.color_attribute() else { return 0 };
        let is_bounded = |bytes: &[u8]| (0.0..=1.0).contains(&Component::Float.value(bytes));
        let elements = attribute.bytes.chunks_exact(attribute.element_bytes);
        elements.filter(|element| !element.chunks_exact(4).all(is_bounded)).count() as u64
    }

    /// `COLOR_0`, if its type is one of those that glTF 2.0 has for colors.
    fn color_attribute(&self) -> Option<(&Attribute, Component)> {
        let attribute = self.attributes.iter().find(|attribute| attribute.semantic == VERTEX_COLORS)?;
        let component = match (attribute.component_type, attribute.normalized) {
            (5126, false) => Component::Float,
            (5121, true) => Component::Byte,
            (5123, true) => Component::Short,
            _ => return None,
        };
        let width = match attribute.kind.as_str() {
            "VEC3" => 3,
            "VEC4" => 4,
            _ => return None,
        };
        (attribute.element_bytes == width * component.byte_count()).then_some((attribute, component))
    }
}

#[derive(Clone, Copy)]
enum Component {
    Byte,
    Short,
    Float,
}

impl Component {
    fn byte_count(self) -> usize {
        match self {
            Self::Byte => 1,
            Self::Short => 2,
            Self::Float => 4,
        }
    }

    fn value(self, bytes: &[u8]) -> f32 {
        match (self, bytes) {
            (Self::Byte, &[code]) => f32::from(code) / 255.0,
            (Self::Short, &[low, high]) => f32::from(u16::from_le_bytes([low, high])) / 65_535.0,
            (Self::Float, &[a, b, c, d]) => f32::from_le_bytes([a, b, c, d]),
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn primitive(component_type: u32, kind: &str, normalized: bool, bytes: Vec<u8>) -> Primitive {
        let attribute = Attribute {
            semantic: VERTEX_COLORS.to_owned(),
            component_type,
            kind: kind.to_owned(),
            normalized,
            element_bytes: bytes.len() / 2,
            bytes,
        };
        Primitive { attributes: vec![attribute], ..Primitive::default() }
    }

    #[test]
    fn all_types_of_colors_are_numbers() {
        let floats: Vec<u8> =
            [0.25f32, 2.0, -1.0, f32::NAN, 1.0, 0.5].into_iter().flat_map(f32::to_le_bytes).collect();
        let own = primitive(5126, "VEC3", false, floats);
        let wanted = [Vec4::new(0.25, 1.0, 0.0, 1.0), Vec4::new(0.0, 1.0, 0.5, 1.0)];
        assert_eq!(own.vertex_colors().unwrap(), wanted);
        assert_eq!((own.unbounded_color_count(), own.has_vertex_alpha()), (2, false));
        let bytes = primitive(5121, "VEC4", true, vec![255, 0, 51, 102, 0, 0, 0, 255]);
        assert_eq!(bytes.vertex_colors().unwrap()[0], Vec4::new(1.0, 0.0, 0.2, 0.4));
        assert_eq!((bytes.unbounded_color_count(), bytes.has_vertex_alpha()), (0, true));
        let shorts: Vec<u8> =
            [65_535u16, 0, 13_107, 1, 2, 3].into_iter().flat_map(u16::to_le_bytes).collect();
        let shorts = primitive(5123, "VEC3", true, shorts);
        assert_eq!(shorts.vertex_colors().unwrap()[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
    }

    #[test]
    fn other_types_are_none() {
        assert_eq!(Primitive::default().vertex_colors(), None);
        for (component_type, kind, normalized) in
            [(5121, "VEC3", false), (5125, "VEC3", false), (5121, "SCALAR", true)]
        {
            assert_eq!(primitive(component_type, kind, normalized, vec![0; 24]).vertex_colors(), None);
        }
        assert_eq!(primitive(5126, "VEC3", false, vec![0; 32]).vertex_colors(), None);
    }
}
