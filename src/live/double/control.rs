//! GVCP, the double's control channel: requests in, acknowledgements out.

use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4};
use std::time::{Duration, Instant};

use super::registers::{
    DISCOVERED, FORMAT, HEARTBEAT_MS, LATCH, LATCHED, MONO_8, PACKET_SIZE, PRIVILEGE, RUNS, Registers, STREAM_PORT,
    STREAM_TO,
};

/// First byte of a request.
const KEY: u8 = 0x42;
const HEADER: usize = 8;
/// Commands; an acknowledgement has the next number.
const DISCOVERY: u16 = 0x0002;
const RESEND: u16 = 0x0040;
const READ_REGISTERS: u16 = 0x0080;
const WRITE_REGISTERS: u16 = 0x0082;
const READ_MEMORY: u16 = 0x0084;
const WRITE_MEMORY: u16 = 0x0086;
/// Most bytes that are read at once, by the specification.
const MOST_READ: usize = 536;
/// Highest bit of the packet size: send one as a trial.
const TRIAL: u32 = 1 << 31;
/// IP, UDP and GVSP headers of a packet \[bytes\].
pub const IP_AND_UDP: usize = 28;

/// Refusals of the specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refused {
    NotImplemented = 0x8001,
    Parameter = 0x8002,
    Address = 0x8003,
    WriteProtected = 0x8004,
    Denied = 0x8006,
}

/// What is to be done besides answering.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Task {
    /// Nothing.
    None,
    /// Packets `first` to `last` of a block again.
    Resend { block: u16, first: u32, last: u32 },
    /// A packet of so many bytes behind its headers.
    Trial(usize),
}

/// The control channel's state: memory and who has the camera.
pub struct Control {
    pub registers: Registers,
    owner: Option<(SocketAddr, Instant)>,
    started: Instant,
}

impl Control {
    /// After power-on.
    pub fn new(registers: Registers) -> Self {
        Self { registers, owner: None, started: Instant::now() }
    }

    /// The camera's clock \[ns\]: it counts from power-on.
    pub fn clock_ns(&self) -> u64 {
        self.started.elapsed().as_nanos() as u64
    }

    /// Takes the camera from a client that has been silent for too long.
    pub fn watch_heartbeat(&mut self) {
        let most = Duration::from_millis(self.registers.get(HEARTBEAT_MS).into());
        if self.owner.is_some_and(|(_, heard)| heard.elapsed() > most) {
            self.release();
        }
    }

    fn release(&mut self) {
        self.owner = None;
        self.registers.set(PRIVILEGE, 0);
        self.registers.set(RUNS, 0);
    }

    /// Where pictures go, while they do.
    pub fn stream_to(&self) -> Option<SocketAddr> {
        let port = self.registers.get(STREAM_PORT) as u16;
        let to = SocketAddrV4::new(Ipv4Addr::from(self.registers.get(STREAM_TO)), port);
        (port != 0 && self.registers.get(RUNS) == 1).then(|| to.into())
    }

    /// Where a trial packet goes.
    pub fn trial_to(&self) -> SocketAddr {
        SocketAddrV4::new(Ipv4Addr::from(self.registers.get(STREAM_TO)), self.registers.get(STREAM_PORT) as u16).into()
    }

    /// The acknowledgement of a request, if it wants one, and what is to be done.
    pub fn answer(&mut self, request: &[u8], from: SocketAddr) -> (Option<Vec<u8>>, Task) {
        let Some((header, data)) = request.split_at_checked(HEADER) else { return (None, Task::None) };
        if header[0] != KEY {
            return (None, Task::None);
        }
        self.watch_heartbeat();
        if let Some((owner, heard)) = &mut self.owner
            && *owner == from
        {
            *heard = Instant::now();
        }
        let command = u16::from_be_bytes([header[2], header[3]]);
        if command == RESEND {
            return (None, resend(data).unwrap_or(Task::None));
        }
        let mut task = Task::None;
        let done = self.carry_out(command, data, from, &mut task);
        let (status, data) = done.map_or_else(|refused| (refused as u16, vec![]), |data| (0, data));
        let wants_answer = header[1] & 1 == 1;
        let answer = [
            &status.to_be_bytes()[..],
            &command.wrapping_add(1).to_be_bytes(),
            &(data.len() as u16).to_be_bytes(),
            &header[6..8],
            &data,
        ]
        .concat();
        (wants_answer.then_some(answer), task)
    }

    fn carry_out(&mut self, command: u16, data: &[u8], from: SocketAddr, task: &mut Task) -> Result<Vec<u8>, Refused> {
        match command {
            DISCOVERY => Ok(self.registers.part(0, DISCOVERED).unwrap_or_default().to_vec()),
            READ_REGISTERS => {
                let read = |at: u32| self.registers.read(at as usize).ok_or(Refused::Address);
                let numbers = words(data)?.map(read).collect::<Result<Vec<_>, _>>()?;
                Ok(numbers.iter().flat_map(|number| number.to_be_bytes()).collect())
            }
            WRITE_REGISTERS => {
                let words = words(data)?.collect::<Vec<_>>();
                for pair in words.chunks(2) {
                    let [at, number] = pair else { return Err(Refused::Parameter) };
                    self.write(*at as usize, *number, from, task)?;
                }
                Ok(written(words.len() / 2))
            }
            READ_MEMORY => {
                let [at, count] = words(data)?.collect::<Vec<_>>()[..] else { return Err(Refused::Parameter) };
                let count = (count & 0xffff) as usize;
                if count > MOST_READ {
                    return Err(Refused::Parameter);
                }
                let part = self.registers.part(at as usize, count).ok_or(Refused::Address)?;
                Ok([&at.to_be_bytes()[..], part].concat())
            }
            WRITE_MEMORY => {
                let words = words(data)?.collect::<Vec<_>>();
                let Some((at, numbers)) = words.split_first() else { return Err(Refused::Parameter) };
                for (i, number) in numbers.iter().enumerate() {
                    self.write((*at as usize).saturating_add(4 * i), *number, from, task)?;
                }
                Ok(written(4 * numbers.len()))
            }
            _ => Err(Refused::NotImplemented),
        }
    }

    fn write(&mut self, at: usize, number: u32, from: SocketAddr, task: &mut Task) -> Result<(), Refused> {
        if !Registers::is_written(at) {
            return Err(if self.registers.read(at).is_some() { Refused::WriteProtected } else { Refused::Address });
        }
        let is_free_or_his = self.owner.is_none_or(|(owner, _)| owner == from);
        // Without the privilege only the privilege may be asked for.
        if !is_free_or_his || (self.owner.is_none() && at != PRIVILEGE) {
            return Err(Refused::Denied);
        }
        match at {
            FORMAT if number != MONO_8 => return Err(Refused::Parameter),
            PRIVILEGE if number == 0 => self.release(),
            PRIVILEGE => {
                self.owner = Some((from, Instant::now()));
                self.registers.set(at, number);
            }
            PACKET_SIZE => {
                // Smaller than its headers and some pixels is none.
                let size = (number & 0xffff).clamp(576, 65_535);
                if number & TRIAL != 0 {
                    *task = Task::Trial(size as usize - IP_AND_UDP);
                }
                self.registers.set(at, size);
            }
            LATCH => {
                let now_ns = self.clock_ns();
                self.registers.set(LATCHED, (now_ns >> 32) as u32);
                self.registers.set(LATCHED + 4, now_ns as u32);
            }
            _ => self.registers.set(at, number),
        }
        Ok(())
    }
}

/// What acknowledges writing.
fn written(count: usize) -> Vec<u8> {
    (count as u32).to_be_bytes().to_vec()
}

fn words(data: &[u8]) -> Result<impl Iterator<Item = u32> + '_, Refused> {
    if data.is_empty() || !data.len().is_multiple_of(4) {
        return Err(Refused::Parameter);
    }
    Ok(data.chunks_exact(4).map(|b| u32::from_be_bytes([b[0], b[1], b[2], b[3]])))
}

/// A request for packets: block, first and last.
fn resend(data: &[u8]) -> Option<Task> {
    let [block, first, last] = words(data).ok()?.take(3).collect::<Vec<_>>()[..] else { return None };
    Some(Task::Resend { block: block as u16, first: first & 0xff_ffff, last: last & 0xff_ffff })
}

#[cfg(test)]
mod tests {
    use super::super::registers::PERIOD_US;
    use super::*;

    fn request(command: u16, data: &[u32]) -> Vec<u8> {
        let mut bytes = vec![KEY, 1];
        bytes.extend(command.to_be_bytes());
        bytes.extend((4 * data.len() as u16).to_be_bytes());
        bytes.extend([0, 7]);
        bytes.extend(data.iter().flat_map(|word| word.to_be_bytes()));
        bytes
    }

    fn client(port: u16) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], port))
    }

    fn double() -> Control {
        Control::new(Registers::new(640, 480, 16_667, Ipv4Addr::LOCALHOST))
    }

    fn status(answer: &[u8]) -> u16 {
        u16::from_be_bytes([answer[0], answer[1]])
    }

    #[test]
    fn a_register_is_read_and_the_number_of_the_request_comes_back() {
        let (answer, _) = double().answer(&request(READ_REGISTERS, &[0x938, 0xd100]), client(1));
        assert_eq!(answer.unwrap(), [0, 0, 0, 0x81, 0, 8, 0, 7, 0, 0, 0x0b, 0xb8, 0, 0, 2, 0x80]);
    }

    #[test]
    fn only_who_has_the_camera_may_write_and_only_what_may_be_written() {
        let mut double = double();
        let mut ask = |port, at: usize, number| {
            status(&double.answer(&request(WRITE_REGISTERS, &[at as u32, number]), client(port)).0.unwrap())
        };
        assert_eq!(ask(1, PERIOD_US, 10_000), 0x8006, "without the privilege");
        assert_eq!((ask(1, PRIVILEGE, 2), ask(2, PRIVILEGE, 2), ask(2, PERIOD_US, 1)), (0, 0x8006, 0x8006));
        assert_eq!((ask(1, PERIOD_US, 10_000), ask(1, 0x48, 1), ask(1, 0x20_0000, 1)), (0, 0x8004, 0x8003));
        assert_eq!((ask(1, PRIVILEGE, 0), ask(2, PRIVILEGE, 2)), (0, 0));
    }

    #[test]
    fn what_is_cut_or_made_up_breaks_nothing() {
        let mut double = double();
        for command in 0..=0x100_u16 {
            for data in [&[][..], &[0xffff_ffff], &[0, 0xffff_ffff], &[0xffff_fffc, 8], &[0, 0xff_ffff, 0xff_ffff]] {
                let whole = request(command, data);
                (0..=whole.len()).for_each(|end| drop(double.answer(&whole[..end], client(1))));
            }
        }
    }

    #[test]
    fn packets_are_asked_for_again() {
        let (answer, task) = double().answer(&request(RESEND, &[0x0000_0005, 3, 4]), client(1));
        assert_eq!((answer, task), (None, Task::Resend { block: 5, first: 3, last: 4 }));
    }
}
