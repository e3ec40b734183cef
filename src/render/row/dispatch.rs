//! The stages of a row that take the most time, compiled for each instruction set. Where the time does not matter, because
//! steps are counted or recorded, they are compiled once.

use super::Painter;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::Instructions;
use crate::mode::Mode;
use crate::render::sample_packet::SamplePacket;
use crate::trace::Observer;
use std::ops::Range;

impl<M: Mode, P: Observer> Painter<'_, M, P> {
    /// Measures the centres of pixels, and colours them if the samples are at the centres.
    pub(super) fn paint_centers(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        match self.setting.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE && !P::OBSERVES => unsafe {
                paint_centers_avx2(avx2, self, columns, packet)
            },
            _ => self.paint_centers_with(columns, packet),
        }
    }

    /// Casts and colours the samples of a packet, and empties it.
    pub(super) fn color_samples(&mut self, packet: &mut SamplePacket) {
        match self.setting.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE && !P::OBSERVES => unsafe {
                color_samples_avx2(avx2, self, packet)
            },
            _ => self.color_samples_with(packet),
        }
    }
}

/// Measures and colours the centres of pixels, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn paint_centers_avx2<M: Mode, P: Observer>(
    _: Avx2,
    painter: &mut Painter<M, P>,
    columns: Range<usize>,
    packet: &mut SamplePacket,
) {
    painter.paint_centers_with(columns, packet);
}

/// Colours the samples of a packet, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn color_samples_avx2<M: Mode, P: Observer>(_: Avx2, painter: &mut Painter<M, P>, packet: &mut SamplePacket) {
    painter.color_samples_with(packet);
}
