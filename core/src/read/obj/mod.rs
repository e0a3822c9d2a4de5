//! OBJ
use super::Context;
use crate::asset::Asset;
use crate::error::{Error, Result};
pub(super) fn read(_bytes: &[u8], _main: &str, _context: &mut Context) -> Result<Asset> {
    Err(Error::internal("not yet"))
}
