//! The OpenAPI document: made of the handlers' declarations, with the options from `OPTIONS`.

use meshcolor::pipeline::{OPTIONS, OptionSpec};
use serde::Serialize;
use utoipa::openapi::path::{ParameterBuilder, ParameterIn};
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder, Schema, Type};
use utoipa::openapi::{InfoBuilder, License, OpenApi, OpenApiBuilder, RefOr, Required};
use utoipa::{PartialSchema, ToSchema};

use crate::jobs::model::{JobOptions, SWITCHES};

/// A model with its files.
#[derive(ToSchema, Serialize)]
pub struct UploadForm {
    /// The model: .glb, .gltf, .obj, .ply, or a .zip that holds exactly one of them.
    #[schema(value_type = String, format = Binary)]
    model: Vec<u8>,
    /// Files that the model names; each part's filename is the path that the model uses.
    #[schema(value_type = Option<Vec<String>>, format = Binary)]
    files: Vec<Vec<u8>>,
    #[schema(value_type = Option<JobOptions>)]
    options: serde_json::Value,
}

/// The part of the document that no handler declares.
pub fn base() -> OpenApi {
    let info = InfoBuilder::new()
        .title("meshcolor")
        .version(env!("CARGO_PKG_VERSION"))
        .description(Some(
            "Converts UV-textured meshes to mesh color textures, which have no seams. A job is submitted, \
             followed, and leaves a bundle, a report and a picture. Errors are RFC 9457 problems; their \
             `code` is stable.",
        ))
        .license(Some(License::new("MIT OR Apache-2.0")))
        .build();
    OpenApiBuilder::new().info(info).build()
}

impl ToSchema for JobOptions {}

impl PartialSchema for JobOptions {
    fn schema() -> RefOr<Schema> {
        RefOr::T(options_schema())
    }
}

fn options_schema() -> Schema {
    let mut object = ObjectBuilder::new()
        .description(Some("The options of a job; all of them have defaults."))
        .additional_properties(Some(AdditionalProperties::<Schema>::FreeForm(false)));
    for spec in OPTIONS {
        let property = ObjectBuilder::new()
            .schema_type(utoipa::openapi::schema::SchemaType::from_iter([Type::String, Type::Number]))
            .description(Some(description(spec)))
            .default(default(spec));
        object = object.property(spec.name, property);
    }
    for switch in &SWITCHES {
        let property = ObjectBuilder::new()
            .schema_type(Type::Boolean)
            .description(Some(switch.doc))
            .default(Some(switch.default.into()));
        object = object.property(switch.name, property);
    }
    object.into()
}

fn description(spec: &OptionSpec) -> String {
    let OptionSpec { doc, allowed, default, .. } = spec;
    let by_quality = if spec.follows_quality {
        format!(" Without it: what `quality` says, {default} for standard.")
    } else {
        String::new()
    };
    format!("{doc}. Allowed: {allowed}.{by_quality}")
}

/// What a document can state as the default: one value, whatever else is set.
fn default(spec: &OptionSpec) -> Option<serde_json::Value> {
    (!spec.follows_quality).then(|| spec.default.into())
}

/// The document as YAML.
///
/// # Errors
/// When it cannot be written as YAML, which no input can cause.
pub fn document() -> Result<String, Box<dyn std::error::Error + Send + Sync>> {
    let (_, mut api) = super::api().split_for_parts();
    for path in ["/v1/jobs", "/v1/convert", "/v1/check"] {
        let post = api.paths.paths.get_mut(path).and_then(|item| item.post.as_mut());
        if let Some(operation) = post {
            operation
                .parameters
                .get_or_insert_default()
                .extend(option_parameters().into_iter().map(RefOr::T));
        }
    }
    Ok(api.to_yaml()?)
}

/// The options as query parameters, for raw bodies.
fn option_parameters() -> Vec<utoipa::openapi::path::Parameter> {
    let parameter = |name: &str, description: String, schema: ObjectBuilder| {
        ParameterBuilder::new()
            .name(name)
            .parameter_in(ParameterIn::Query)
            .required(Required::False)
            .description(Some(description))
            .schema(Some(schema))
            .build()
    };
    let mut parameters: Vec<_> = OPTIONS
        .iter()
        .map(|spec| {
            let schema = ObjectBuilder::new().schema_type(Type::String).default(default(spec));
            parameter(spec.name, description(spec), schema)
        })
        .collect();
    parameters.extend(SWITCHES.iter().map(|switch| {
        let schema = ObjectBuilder::new().schema_type(Type::Boolean).default(Some(switch.default.into()));
        parameter(switch.name, switch.doc.to_owned(), schema)
    }));
    parameters
}
