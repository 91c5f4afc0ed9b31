//! Values of samples or pixels, by channel.

/// Encoding of a value that does not exist, such as the visible fraction of a light that lies below the sample's horizon.
///
/// Every NaN means the same. NaN equals nothing, itself included: test with [`f32::is_nan`], or read with [`Values::get`].
pub const NO_VALUE: f32 = f32::NAN;

/// Values of samples or pixels in one or more channels, one channel after another.
///
/// One channel is a factor of the light's whole radiance; three are the factors of its red, green and blue.
#[derive(Clone, Debug, Default)]
pub struct Values {
    data: Vec<f32>,
    channels: usize,
    len: usize,
}

impl Values {
    /// Sets the number of channels and the number of values in each; keeps the memory. Every value is then to be
    /// written: until then it is 0 or an earlier one.
    pub fn reset(&mut self, channels: usize, len: usize) {
        (self.channels, self.len) = (channels, len);
        self.data.resize(channels.saturating_mul(len), 0.0);
    }

    /// Number of channels.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Number of values in each channel.
    pub fn len(&self) -> usize {
        self.len
    }

    /// True if the channels have no values.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns a channel's values, [`NO_VALUE`] where there is none; an empty slice for a channel that does not exist.
    pub fn channel(&self, channel: usize) -> &[f32] {
        let start = channel.saturating_mul(self.len);
        self.data.get(start..start.saturating_add(self.len)).unwrap_or_default()
    }

    /// Returns a channel's values for writing; an empty slice for a channel that does not exist.
    pub fn channel_mut(&mut self, channel: usize) -> &mut [f32] {
        let start = channel.saturating_mul(self.len);
        self.data.get_mut(start..start.saturating_add(self.len)).unwrap_or_default()
    }

    /// Returns all channels for writing, one after another.
    pub fn all_mut(&mut self) -> &mut [f32] {
        &mut self.data
    }

    /// Returns one value, or `None` where there is none.
    pub fn get(&self, channel: usize, index: usize) -> Option<f32> {
        self.channel(channel).get(index).copied().filter(|value| !value.is_nan())
    }

    /// Returns the bytes held.
    pub fn bytes(&self) -> usize {
        self.data.capacity() * size_of::<f32>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_kept_apart() {
        let mut values = Values::default();
        assert!(values.is_empty() && values.channel(0).is_empty() && values.get(0, 0).is_none());
        values.reset(3, 2);
        assert!((0..3).all(|channel| values.get(channel, 1) == Some(0.0)));
        for channel in 0..3 {
            values.channel_mut(channel).copy_from_slice(&[channel as f32, NO_VALUE]);
        }
        for channel in 0..3 {
            assert_eq!(values.channel(channel)[0], channel as f32);
            assert_eq!((values.get(channel, 0), values.get(channel, 1)), (Some(channel as f32), None));
        }
        assert!(values.channel(3).is_empty() && values.channel_mut(usize::MAX).is_empty());
        assert_eq!((values.get(0, 2), values.get(3, 0)), (None, None));
        assert_eq!((values.channels(), values.len(), values.all_mut().len()), (3, 2, 6));
        let bytes = values.bytes();
        values.reset(1, 4);
        assert_eq!((values.channel(0).len(), values.channel(1).len(), values.bytes()), (4, 0, bytes));
    }
}
