//! The tracing of a packet, which takes the most time of a row, compiled for each instruction set. Where the time does
//! not matter, because steps are counted, it is compiled once.

use super::{Painter, Wanted};
#[cfg(target_arch = "x86_64")]
use crate::math::avx::Avx;
use crate::math::f64x4::Scalar;
#[cfg(target_arch = "x86_64")]
use crate::math::instructions::Avx2;
use crate::math::instructions::{Instructions, Portable};
use crate::render::RenderMode;
use crate::render::sample_packet::SamplePacket;
use crate::scene::Color;

impl<M: RenderMode> Painter<'_, M> {
    /// Traces the samples of a packet, and returns their colours, if they are wanted.
    pub(super) fn trace(&mut self, wanted: Wanted, packet: &mut SamplePacket) -> [Color; SamplePacket::SIZE] {
        match self.setting.caster.instructions {
            #[cfg(target_arch = "x86_64")]
            // SAFETY: `avx2` proves that the processor has all that the function is compiled for.
            Instructions::Avx2(avx2) if !M::AS_COURSE => unsafe { trace_avx2(avx2, self, wanted, packet) },
            _ => self.trace_with::<Scalar>(Portable, wanted, packet),
        }
    }
}

/// The same, compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
#[inline(never)]
fn trace_avx2<M: RenderMode>(
    avx2: Avx2,
    painter: &mut Painter<M>,
    wanted: Wanted,
    packet: &mut SamplePacket,
) -> [Color; SamplePacket::SIZE] {
    painter.trace_with::<Avx>(avx2, wanted, packet)
}
