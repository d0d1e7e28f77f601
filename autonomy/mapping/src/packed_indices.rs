//! Ascending indices in little memory: thousands of viewpoints see tens of thousands of points each.

/// Ascending indices: the gaps between them as LEB128, mostly one byte each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PackedIndices {
    gaps: Vec<u8>,
    len: usize,
}

impl PackedIndices {
    /// Of indices that ascend. One that does not is left out.
    pub fn new(ascending: &[u32]) -> Self {
        let mut packed = Self { gaps: Vec::with_capacity(ascending.len() + 16), len: 0 };
        let mut next = 0;
        for index in ascending {
            let Some(mut gap) = index.checked_sub(next) else { continue };
            next = index.saturating_add(1);
            packed.len += 1;
            while gap >= 0x80 {
                packed.gaps.push(gap as u8 | 0x80);
                gap >>= 7;
            }
            packed.gaps.push(gap as u8);
        }
        packed.gaps.shrink_to_fit();
        packed
    }

    /// Their number.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The indices, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        let (mut bytes, mut next) = (self.gaps.iter(), 0_u32);
        std::iter::from_fn(move || {
            let (mut gap, mut shift) = (0_u32, 0);
            loop {
                let byte = *bytes.next()?;
                gap |= u32::from(byte & 0x7f) << shift;
                shift += 7;
                if byte & 0x80 == 0 {
                    break;
                }
            }
            let index = next + gap;
            next = index.saturating_add(1);
            Some(index)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_come_back_and_take_a_byte_where_they_are_dense() {
        for indices in
            [vec![], vec![0], vec![u32::MAX], vec![0, 1, 127, 128, 300, 1 << 20, u32::MAX - 1, u32::MAX]]
        {
            let packed = PackedIndices::new(&indices);
            assert_eq!(packed.iter().collect::<Vec<_>>(), indices);
            assert_eq!((packed.len(), packed.is_empty()), (indices.len(), indices.is_empty()));
        }
        let dense: Vec<u32> = (0..1000).map(|index| index * 3).collect();
        assert_eq!(PackedIndices::new(&dense).gaps.len(), 1000);
    }
}
