//! The stages of a row that take the most time, compiled for each instruction set. Where the time does not matter,
//! because steps are counted or recorded, they are compiled once.

use super::Painter;
#[cfg(target_arch = "x86_64")]
use crate::math::avx::Avx;
use crate::math::f64x4::Scalar;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::mode::Mode;
use crate::render::sample_packet::SamplePacket;
use crate::scene::Color;
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
            _ => self.paint_centers_with::<Scalar>(Portable, columns, packet),
        }
    }

    /// Takes the samples of the pixels in these columns.
    pub(super) fn take_samples(&mut self, columns: Range<usize>, packet: &mut SamplePacket) {
        match self.setting.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE && !P::OBSERVES => unsafe {
                take_samples_avx2(avx2, self, columns, packet)
            },
            _ => self.take_samples_with(columns, packet),
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
            _ => self.color_samples_with::<Scalar>(Portable, packet),
        }
    }

    /// The colours of a packet's samples.
    pub(super) fn colors_of(&mut self, packet: &mut SamplePacket) -> [Color; SamplePacket::SIZE] {
        match self.setting.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE && !P::OBSERVES => unsafe {
                colors_of_avx2(avx2, self, packet)
            },
            _ => self.colors_of_with::<Scalar>(Portable, packet),
        }
    }
}

/// Measures and colours the centres of pixels, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn paint_centers_avx2<M: Mode, P: Observer>(
    avx2: Avx2,
    painter: &mut Painter<M, P>,
    columns: Range<usize>,
    packet: &mut SamplePacket,
) {
    painter.paint_centers_with::<Avx>(avx2, columns, packet);
}

/// Takes samples, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn take_samples_avx2<M: Mode, P: Observer>(
    _: Avx2,
    painter: &mut Painter<M, P>,
    columns: Range<usize>,
    packet: &mut SamplePacket,
) {
    painter.take_samples_with(columns, packet);
}

/// Colours the samples of a packet, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn color_samples_avx2<M: Mode, P: Observer>(
    avx2: Avx2,
    painter: &mut Painter<M, P>,
    packet: &mut SamplePacket,
) {
    painter.color_samples_with::<Avx>(avx2, packet);
}

/// Casts and colours the samples of a packet, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn colors_of_avx2<M: Mode, P: Observer>(
    avx2: Avx2,
    painter: &mut Painter<M, P>,
    packet: &mut SamplePacket,
) -> [Color; SamplePacket::SIZE] {
    painter.colors_of_with::<Avx>(avx2, packet)
}
