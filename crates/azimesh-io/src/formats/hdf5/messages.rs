//! Messages of object headers, and the message of a link.

use azimesh_core::error::{Error, Result};

/// The type of a message that is a link.
pub(super) const LINK: u8 = 6;

/// Messages of a header, one after another.
#[derive(Default)]
pub(super) struct Messages(pub Vec<u8>);

impl Messages {
    pub fn push(&mut self, kind: u8, flags: u8, body: &[u8]) -> Result<()> {
        let size = u16::try_from(body.len()).map_err(|_| {
            Error::input(format!(
                "the header of an HDF5 object has {} bytes; it can have 65535",
                body.len()
            ))
        })?;
        self.0.push(kind);
        self.0.extend(size.to_le_bytes());
        self.0.push(flags);
        self.0.extend(body);
        Ok(())
    }
}

/// The message of a link to the object at `address`.
pub(super) fn link(order: usize, name: &str, address: u64) -> Result<Vec<u8>> {
    const WITH_ORDER_AND_CHARSET: u8 = 0x14;
    const LENGTH_OF_2_BYTES: u8 = 0x01;
    const UTF8: u8 = 1;
    let length = u16::try_from(name.len()).map_err(|_| {
        Error::input(format!(
            "a name has {} bytes; HDF5 allows 65535",
            name.len()
        ))
    })?;
    let mut message = vec![1, WITH_ORDER_AND_CHARSET | LENGTH_OF_2_BYTES];
    message.extend((order as u64).to_le_bytes());
    message.push(UTF8);
    message.extend(length.to_le_bytes());
    message.extend(name.as_bytes());
    message.extend(address.to_le_bytes());
    Ok(message)
}
