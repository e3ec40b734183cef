//! The processor time of this process.

use std::time::Duration;

/// Returns the processor time of all threads so far, or zero if the system does not tell.
#[cfg(unix)]
pub fn processor_time() -> Duration {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: the clock is one that POSIX names, and it is written to a `timespec` of ours.
    let is_known = unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) } == 0;
    if is_known { Duration::new(time.tv_sec as u64, time.tv_nsec as u32) } else { Duration::ZERO }
}

/// Returns the processor time of all threads so far, or zero if the system does not tell.
#[cfg(windows)]
pub fn processor_time() -> Duration {
    use windows_sys::Win32::Foundation::FILETIME;
    use windows_sys::Win32::System::Threading::{GetCurrentProcess, GetProcessTimes};
    let [mut made, mut ended, mut system, mut user] = [FILETIME::default(); 4];
    // SAFETY: the handle of the own process is always valid, and the four times are variables of ours.
    unsafe { GetProcessTimes(GetCurrentProcess(), &mut made, &mut ended, &mut system, &mut user) };
    let ticks = |time: FILETIME| (u64::from(time.dwHighDateTime) << 32) | u64::from(time.dwLowDateTime);
    Duration::from_nanos(100 * (ticks(system) + ticks(user)))
}

/// Returns zero, since the system does not tell.
#[cfg(not(any(unix, windows)))]
pub fn processor_time() -> Duration {
    Duration::ZERO
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_takes_processor_time() {
        let start = processor_time();
        // Windows counts in steps of 16 ms.
        while processor_time() < start + Duration::from_millis(20) {}
    }
}
