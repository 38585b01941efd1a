//! An ATmega32 in simavr.
//!
//! In: bytes for its serial line, levels of its pins, voltages at its converter, time. Out: the
//! bytes it sends, its registers.
//!
//! All `unsafe` of this package is here: calls into simavr's C. Its rules are few: an `avr_t` is
//! used by one thread at a time, lives until it is terminated, and what a callback is given must
//! live as long.

use std::collections::VecDeque;
use std::ffi::{CStr, CString, c_void};
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use simavr_ffi as avr;

/// Clock of the RP6's controller, Hz.
pub(crate) const FREQUENCY: u64 = 8_000_000;

/// Addresses in data space; I/O registers stand 0x20 higher than in the data sheet's I/O column.
const OCR1B: usize = 0x48;
const OCR1A: usize = 0x4A;
const PORTC: usize = 0x35;

/// A running chip.
pub struct Chip {
    avr: *mut avr::avr_t,
    /// What simavr's callbacks write; allocated by `new`, freed by `drop`, and looked at only while
    /// the chip does not run.
    watched: *mut Watched,
    /// simavr counts from 0 again after a reset: cycles of the lives before, and how many those
    /// were.
    cycles_before: u64,
    resets: u32,
}

// SAFETY: both pointers are the chip's own, and simavr keeps nothing of a chip in the thread that
// runs it.
unsafe impl Send for Chip {}

/// What the chip does between two looks at it.
struct Watched {
    avr: *const avr::avr_t,
    sent: VecDeque<u8>,
    /// Cycle at which the servo's pin rose, and how long it was high the last time.
    rose: Option<u64>,
    pulse: Option<u64>,
}

fn ioctl(letters: [u8; 4]) -> u32 {
    u32::from_be_bytes(letters)
}

/// Called by simavr for each byte that the chip sends.
unsafe extern "C" fn on_byte(_: *mut avr::avr_irq_t, value: u32, watched: *mut c_void) {
    // SAFETY: registered with the chip's own `watched`, which lives as long as the chip; called
    // only from within `avr_run`, while nobody else looks at it.
    let watched = unsafe { &mut *watched.cast::<Watched>() };
    watched.sent.push_back(value as u8);
}

/// Called by simavr when the servo's pin is written.
unsafe extern "C" fn on_servo(_: *mut avr::avr_irq_t, value: u32, watched: *mut c_void) {
    // SAFETY: as in `on_byte`; `avr` is the running chip.
    let (watched, cycle) = unsafe {
        let watched = &mut *watched.cast::<Watched>();
        let cycle = (*watched.avr).cycle;
        (watched, cycle)
    };
    if value & 1 == 1 {
        watched.rose = watched.rose.or(Some(cycle));
    } else if let Some(rose) = watched.rose.take() {
        // A reset in between begins to count again: that is no pulse.
        watched.pulse = cycle.checked_sub(rose);
    }
}

impl Chip {
    /// A chip with this program in its flash, just after power-on.
    ///
    /// # Errors
    /// If the file cannot be read, or simavr does not know the ATmega32.
    pub fn new(elf: &Path) -> Result<Self> {
        let path = CString::new(
            elf.to_str()
                .context("the path of the firmware is no text")?,
        )?;
        // SAFETY: `firmware` is plain data for which all zeros is a valid value (as in simavr's own
        // main), and both functions only read the strings, which live until they return.
        let avr = unsafe {
            let mut firmware: avr::elf_firmware_t = std::mem::zeroed();
            ensure!(
                avr::elf_read_firmware(path.as_ptr(), &mut firmware) == 0,
                "simavr cannot read {}",
                elf.display()
            );
            let avr = avr::avr_make_mcu_by_name(c"atmega32".as_ptr());
            ensure!(!avr.is_null(), "simavr has no ATmega32");
            avr::avr_init(avr);
            firmware.frequency = FREQUENCY as u32;
            (firmware.vcc, firmware.avcc, firmware.aref) = (5_000, 5_000, 5_000);
            avr::avr_load_firmware(avr, &mut firmware);
            (*avr).set_log(1); // errors only
            avr
        };
        let watched = Box::new(Watched {
            avr,
            sent: VecDeque::new(),
            rose: None,
            pulse: None,
        });
        let mut chip = Self {
            avr,
            watched: Box::into_raw(watched),
            cycles_before: 0,
            resets: 0,
        };
        chip.watch();
        chip.mend_watchdog();
        Ok(chip)
    }

    /// On an ATmega32 the watchdog has no vector of its own, and simavr leaves its IRQs without a
    /// pool; the reset that it causes would then read through a null pointer.
    fn mend_watchdog(&mut self) {
        // SAFETY: the list of modules lives as long as `avr`; each has a name that ends with a
        // zero, and the one named `watchdog` is the first field of an `avr_watchdog_t`.
        unsafe {
            let pool = &raw mut (*self.avr).irq_pool;
            let mut module = (*self.avr).io_port;
            while !module.is_null() {
                if CStr::from_ptr((*module).kind) == c"watchdog" {
                    let watchdog = module.cast::<avr::avr_watchdog_t>();
                    for irq in &mut (*watchdog).watchdog.irq {
                        irq.pool = pool;
                    }
                }
                module = (*module).next;
            }
        }
    }

    fn watch(&mut self) {
        let mut flags = 0_u32;
        let output = self.irq(*b"uar0", avr::UART_IRQ_OUTPUT);
        let servo = self.irq(*b"iogA", avr::IOPORT_IRQ_PIN0 + 1);
        // SAFETY: both are IRQs of this chip, `watched` lives as long as it does; `flags` is read
        // before the call returns.
        unsafe {
            avr::avr_irq_register_notify(output, Some(on_byte), self.watched.cast());
            avr::avr_irq_register_notify(servo, Some(on_servo), self.watched.cast());
            avr::avr_ioctl(self.avr, ioctl(*b"uas0"), (&raw mut flags).cast());
        }
    }

    /// Cycles since power-on, whatever resets came in between.
    #[must_use]
    pub fn cycle(&self) -> u64 {
        self.cycles_before + self.cycle_of_life()
    }

    /// How often the chip was reset since power-on.
    #[must_use]
    pub fn resets(&self) -> u32 {
        self.resets
    }

    fn cycle_of_life(&self) -> u64 {
        // SAFETY: `avr` is valid from `new` to `drop`.
        unsafe { (*self.avr).cycle }
    }

    /// Runs until this cycle.
    ///
    /// # Errors
    /// If the program crashed (a bad instruction, a stack beyond the memory).
    pub fn run_until(&mut self, cycle: u64) -> Result<()> {
        while self.cycle() < cycle {
            let before = self.cycle_of_life();
            // SAFETY: `avr` is valid; the callbacks touch nothing but `watched`, which nobody else
            // holds now.
            let state = unsafe { avr::avr_run(self.avr) };
            if state == avr::cpu_Crashed as i32 || state == avr::cpu_Done as i32 {
                bail!("the firmware crashed at cycle {}", self.cycle());
            }
            if self.cycle_of_life() < before {
                self.cycles_before += before;
                self.resets += 1;
            }
        }
        Ok(())
    }

    /// Pulls the reset line: the program starts again.
    pub fn reset(&mut self) {
        let before = self.cycle_of_life();
        // SAFETY: `avr` is valid, and does not run now.
        unsafe { avr::avr_reset(self.avr) };
        if self.cycle_of_life() < before {
            self.cycles_before += before;
        }
        self.resets += 1;
    }

    /// The bytes that the chip sent since this was last asked.
    pub fn take_sent(&mut self) -> Vec<u8> {
        // SAFETY: the chip does not run now, so no callback holds it.
        unsafe { (*self.watched).sent.drain(..).collect() }
    }

    /// A byte comes over the serial line.
    pub fn receive(&mut self, byte: u8) {
        self.raise(*b"uar0", avr::UART_IRQ_INPUT, byte.into());
    }

    /// Puts a pin, `port` from b'A' to b'D', at a level.
    pub fn set_pin(&mut self, port: u8, pin: u32, level: bool) {
        self.raise(
            [b'i', b'o', b'g', port],
            avr::IOPORT_IRQ_PIN0 + pin,
            level.into(),
        );
    }

    /// Puts a voltage on a channel of the converter, mV.
    pub fn set_millivolts(&mut self, channel: u32, millivolts: u32) {
        self.raise(*b"adc0", avr::ADC_IRQ_ADC0 + channel, millivolts);
    }

    /// Duty of the left and the right motor, as in the compare registers.
    #[must_use]
    pub fn duties(&self) -> [u16; 2] {
        let register = |low| u16::from_le_bytes([self.data(low), self.data(low + 1)]);
        [register(OCR1B), register(OCR1A)]
    }

    /// Whether the left and the right motor are set backwards.
    #[must_use]
    pub fn backwards(&self) -> [bool; 2] {
        let port = self.data(PORTC);
        [port & (1 << 2) != 0, port & (1 << 3) != 0]
    }

    /// Which ranger the select lines put on the converter.
    #[must_use]
    pub fn selected_ranger(&self) -> usize {
        usize::from(self.data(PORTC) >> 4 & 3)
    }

    /// Length of the servo's last pulse, µs; `None` before the first.
    #[must_use]
    pub fn servo_pulse(&self) -> Option<f64> {
        // SAFETY: the chip does not run now, so no callback holds it.
        let cycles = unsafe { (*self.watched).pulse };
        cycles.map(|cycles| cycles as f64 * 1e6 / FREQUENCY as f64)
    }

    /// Makes the program hang where it is, by an instruction that jumps to itself, until the chip
    /// is reset. Only the hardware watchdog can do that.
    ///
    /// # Errors
    /// If nothing has reset the chip within `most` seconds.
    pub fn hang(&mut self, most: f64) -> Result<()> {
        const JUMP_TO_ITSELF: [u8; 2] = [0xFF, 0xCF]; // rjmp .-2
        // SAFETY: the word at the program counter is within the flash; both pointers are valid
        // while `avr` is.
        let (at, word) = unsafe {
            let at = (*self.avr)
                .flash
                .add((*self.avr).pc as usize)
                .cast::<[u8; 2]>();
            (at, at.replace(JUMP_TO_ITSELF))
        };
        let (resets, end) = (self.resets, self.cycle() + (most * FREQUENCY as f64) as u64);
        while self.resets == resets && self.cycle() < end {
            let next = self.cycle() + 1;
            self.run_until(next)?;
        }
        // SAFETY: as above.
        unsafe { at.write(word) };
        ensure!(
            self.resets > resets,
            "nothing reset the chip within {most} s"
        );
        Ok(())
    }

    fn data(&self, address: usize) -> u8 {
        assert!(address < 0x860, "beyond the memory of an ATmega32");
        // SAFETY: `data` holds the registers and the 2 KB of memory, 0x860 bytes.
        unsafe { *(*self.avr).data.add(address) }
    }

    fn raise(&mut self, letters: [u8; 4], index: u32, value: u32) {
        let irq = self.irq(letters, index);
        // SAFETY: `irq` belongs to this chip.
        unsafe { avr::avr_raise_irq(irq, value) }
    }

    fn irq(&mut self, letters: [u8; 4], index: u32) -> *mut avr::avr_irq_t {
        // SAFETY: `avr` is valid; an unknown name gives null, which is refused here.
        let irq = unsafe { avr::avr_io_getirq(self.avr, ioctl(letters), index as i32) };
        assert!(!irq.is_null(), "simavr has no {letters:?} {index}");
        irq
    }
}

impl Drop for Chip {
    fn drop(&mut self) {
        // SAFETY: the last use of both; the callbacks end with the chip.
        unsafe {
            avr::avr_terminate(self.avr);
            drop(Box::from_raw(self.watched));
        }
    }
}
