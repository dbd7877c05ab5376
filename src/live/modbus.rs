//! Modbus TCP: the guide's last answer as registers, for a PLC. The standard library is enough: a request and its answer are a
//! few bytes.
//!
//! Functions 3 and 4 read the same block, 6 and 16 write its first registers. Numbers of 32 bits lie in two registers, the
//! higher first. One request is answered from one answer of the guide: no value is torn.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use super::camera::LiveClock;
use super::guide::Correction;
use super::robot::{Shared, Told};

/// Clients at a time. Chosen: a PLC, its panel, and who looks after them.
const MOST_CLIENTS: usize = 8;
const WAIT: Duration = Duration::from_millis(50);
/// Length of the header, and longest message after it, by the Modbus TCP specification.
const HEADER: usize = 7;
const LONGEST: usize = 253;
/// Most registers of one request, by the specification.
const MOST_READ: u16 = 125;
const MOST_WRITTEN: u16 = 123;

/// What a number without value is: the smallest one, as LMI's sensors send it.
const NO_VALUE: i32 = i32::MIN;
/// Ages without value.
const NO_AGE: u32 = u32::MAX;

/// First register behind those that a PLC writes, and behind all.
const WRITTEN: u16 = 3;
const END: u16 = 1013;

/// The block at one moment.
pub struct Registers {
    written: [u16; WRITTEN as usize],
    states: [u16; 5],
    stamps: [u16; 4],
    values: [u16; 13],
}

impl Registers {
    /// The block of an answer at `now_s`; `written` is what the PLC wrote.
    #[must_use]
    pub fn of(told: Option<&Told>, written: [u16; WRITTEN as usize], now_s: f64) -> Self {
        let answer = told.map(|told| &told.answer);
        let beat = told.map_or(0, |told| told.cycle as u16);
        let micrometres = |mm: f64| (mm * 1e3).round().clamp(-2e9, 2e9) as i32;
        let value = |mm: Option<f64>| -> [u16; 3] {
            let number = mm.map_or(NO_VALUE, micrometres).cast_unsigned();
            [(number >> 16) as u16, number as u16, u16::from(mm.is_none())]
        };
        let is_step = answer.is_some_and(|answer| matches!(answer.correction, Correction::Step(_)));
        let age_ms =
            answer.and_then(|answer| answer.age_s).map_or(NO_AGE, |age_s| (age_s * 1e3).clamp(0.0, 4e9) as u32);
        let clock_ms = (now_s * 1e3) as u64 as u32;
        let halves = |number: u32| [(number >> 16) as u16, number as u16];
        let [total, remaining, path, lateral] = [
            // What was sent stays where it is; whether it is still led there the decision tells.
            answer.filter(|_| is_step).map(|answer| answer.total_mm),
            answer.filter(|_| is_step).and_then(|answer| answer.remaining_mm),
            answer.map(|answer| answer.pose.path_mm),
            answer.map(|answer| answer.pose.lateral_mm),
        ]
        .map(value);
        let mut values = [0; 13];
        for (to, from) in values.iter_mut().zip([total, remaining, path, lateral].concat().into_iter().chain([beat])) {
            *to = from;
        }
        let [age_high, age_low] = halves(age_ms);
        let [clock_high, clock_low] = halves(clock_ms);
        let (state, why) = answer.map_or((0, 0), |answer| (answer.state.code(), answer.why.code()));
        Self {
            written,
            states: [state, why, beat, u16::from(is_step), u16::from(answer.is_some())],
            stamps: [age_high, age_low, clock_high, clock_low],
            values,
        }
    }

    /// One register; those that mean nothing are 0.
    fn at(&self, address: u16) -> u16 {
        let part = |from: u16, block: &[u16]| {
            address.checked_sub(from).and_then(|offset| block.get(usize::from(offset)).copied())
        };
        let found = part(0, &self.written).or_else(|| part(300, &self.states)).or_else(|| part(900, &self.stamps));
        found.or_else(|| part(1000, &self.values)).unwrap_or(0)
    }
}

/// Exceptions of the specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refused {
    Function = 1,
    Address = 2,
    Value = 3,
}

/// The answer to one request, function and data without the header.
fn answer(request: &[u8], registers: &Registers, mut write: impl FnMut(u16, u16)) -> Vec<u8> {
    let function = request.first().copied().unwrap_or(0);
    let word = |at: usize| request.get(at..at + 2).map(|b| u16::from_be_bytes([b[0], b[1]])).ok_or(Refused::Value);
    let mut respond = || match function {
        3 | 4 => {
            let (from, count) = (word(1)?, word(3)?);
            if !(1..=MOST_READ).contains(&count) {
                return Err(Refused::Value);
            }
            let to = from.checked_add(count).filter(|to| *to <= END).ok_or(Refused::Address)?;
            let words = (from..to).flat_map(|address| registers.at(address).to_be_bytes());
            Ok([function, (2 * count) as u8].into_iter().chain(words).collect())
        }
        6 => {
            let (address, value) = (word(1)?, word(3)?);
            if address >= WRITTEN {
                return Err(Refused::Address);
            }
            write(address, value);
            Ok(request[..5].to_vec())
        }
        16 => {
            let (from, count) = (word(1)?, word(3)?);
            let bytes = usize::from(2 * count.min(MOST_WRITTEN));
            if !(1..=MOST_WRITTEN).contains(&count) || request.len() != 6 + bytes || usize::from(request[5]) != bytes {
                return Err(Refused::Value);
            }
            if from.checked_add(count).is_none_or(|to| to > WRITTEN) {
                return Err(Refused::Address);
            }
            for i in 0..count {
                write(from + i, word(6 + 2 * usize::from(i))?);
            }
            Ok(request[..5].to_vec())
        }
        _ => Err(Refused::Function),
    };
    respond().unwrap_or_else(|refused| vec![function | 0x80, refused as u8])
}

/// Serves until the run ends. A client that says what is no Modbus is hung up on.
///
/// # Errors
/// When the port cannot be used any more.
pub fn serve(listener: &TcpListener, shared: &Shared, clock: LiveClock) -> std::io::Result<()> {
    listener.set_nonblocking(true)?;
    std::thread::scope(|scope| {
        let mut clients: Vec<std::thread::ScopedJoinHandle<'_, ()>> = vec![];
        while !shared.is_ending() {
            clients.retain(|client| !client.is_finished());
            match listener.accept() {
                Ok((stream, _)) if clients.len() < MOST_CLIENTS => {
                    clients.push(scope.spawn(move || drop(serve_client(stream, shared, clock))));
                }
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::WouldBlock => std::thread::sleep(WAIT),
                // A client that left before it was accepted.
                Err(error) if matches!(error.kind(), ErrorKind::ConnectionAborted | ErrorKind::Interrupted) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    })
}

fn serve_client(mut stream: TcpStream, shared: &Shared, clock: LiveClock) -> std::io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(WAIT))?;
    stream.set_write_timeout(Some(Duration::from_secs(1)))?;
    let (mut bytes, mut buffer) = (vec![], [0; 512]);
    while !shared.is_ending() {
        match stream.read(&mut buffer) {
            Ok(0) => return Ok(()),
            Ok(count) => bytes.extend_from_slice(&buffer[..count]),
            Err(error) => match error.kind() {
                ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => continue,
                _ => return Err(error),
            },
        }
        while let Some(length) = message_length(&bytes)? {
            let Some(message) = bytes.get(..length) else { break };
            let registers = Registers::of(shared.last().as_ref(), shared.orders.written(), clock.now_s());
            let data = answer(&message[HEADER..], &registers, |address, value| {
                shared.orders.write(address, value, clock.now_s());
            });
            let mut reply = message[..4].to_vec();
            reply.extend_from_slice(&(data.len() as u16 + 1).to_be_bytes());
            reply.push(message[6]);
            reply.extend_from_slice(&data);
            bytes.drain(..length);
            stream.write_all(&reply)?;
        }
    }
    Ok(())
}

/// Length of the first message, once its header is there.
fn message_length(bytes: &[u8]) -> std::io::Result<Option<usize>> {
    let Some(header) = bytes.get(..HEADER) else { return Ok(None) };
    let (protocol, length) = (u16::from_be_bytes([header[2], header[3]]), u16::from_be_bytes([header[4], header[5]]));
    let length = usize::from(length);
    if protocol != 0 || !(2..=LONGEST + 1).contains(&length) {
        return Err(ErrorKind::InvalidData.into());
    }
    Ok(Some(HEADER - 1 + length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::{Answer, Pose, State, Why};

    fn registers(correction: Correction) -> Registers {
        let answer = Answer {
            state: State::Ok,
            why: Why::Fine,
            correction,
            pose: Pose { path_mm: 100.0, lateral_mm: -1.0 },
            total_mm: -1.25,
            remaining_mm: Some(0.02),
            age_s: Some(0.016),
        };
        Registers::of(
            Some(&Told {
                answer,
                cycle: 65_541,
                #[cfg(feature = "page")]
                late: 0,
            }),
            [7, 8, 9],
            70.0,
        )
    }

    fn read(registers: &Registers, from: u16, count: u16) -> Vec<u8> {
        let request = [&[3][..], &from.to_be_bytes(), &count.to_be_bytes()].concat();
        answer(&request, registers, |_, _| unreachable!())
    }

    #[test]
    fn the_block_lies_where_the_documentation_says() {
        let registers = registers(Correction::Step(0.01));
        assert_eq!(read(&registers, 300, 5), [3, 10, 0, 1, 0, 0, 0, 5, 0, 1, 0, 1]);
        assert_eq!(read(&registers, 900, 2), [3, 4, 0, 0, 0, 16]);
        assert_eq!(read(&registers, 1000, 3), [&[3, 6][..], &(-1250_i32).to_be_bytes(), &[0, 0]].concat());
        assert_eq!(read(&registers, 1012, 1), [3, 2, 0, 5]);
        assert_eq!(read(&registers, 0, 4), [3, 8, 0, 7, 0, 8, 0, 9, 0, 0]);
    }

    #[test]
    fn what_is_not_known_is_no_zero() {
        let values = read(&registers(Correction::Hold), 1000, 6);
        let unknown = [&i32::MIN.to_be_bytes()[..], &[0, 1]].concat();
        assert_eq!(values[2..], [unknown.clone(), unknown].concat());
    }

    #[test]
    fn only_the_first_registers_are_written_and_what_is_wrong_is_refused_as_the_specification_says() {
        let registers = registers(Correction::Hold);
        let mut written = vec![];
        let mut ask = |request: &[u8]| answer(request, &registers, |address, value| written.push((address, value)));
        assert_eq!(ask(&[6, 0, 0, 0, 1]), [6, 0, 0, 0, 1]);
        assert_eq!(ask(&[16, 0, 1, 0, 2, 4, 0, 3, 0, 4]), [16, 0, 1, 0, 2]);
        assert_eq!(ask(&[6, 1, 44, 0, 1]), [0x86, 2]);
        assert_eq!(ask(&[16, 0, 2, 0, 2, 4, 0, 3, 0, 4]), [0x90, 2]);
        assert_eq!(ask(&[16, 0, 0, 0, 2, 4, 0, 3]), [0x90, 3]);
        assert_eq!(ask(&[3, 255, 255, 0, 1]), [0x83, 2]);
        assert_eq!(ask(&[3, 0, 0, 0, 126]), [0x83, 3]);
        assert_eq!(ask(&[43, 14]), [0xab, 1]);
        assert_eq!(ask(&[3]), [0x83, 3]);
        assert_eq!(written, [(0, 1), (1, 3), (2, 4)]);
    }
}
