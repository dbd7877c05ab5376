//! What the double's memory holds: the bootstrap registers of GigE Vision, its own few, and the description of these in GenICam's
//! XML, by which a client finds them.

use std::net::Ipv4Addr;

/// Where the description begins, and the end of all.
const XML_AT: usize = 0x10000;
const END: usize = 0x12000;

/// Bootstrap registers, by the GigE Vision specification.
pub const HEARTBEAT_MS: usize = 0x938;
const CLOCK_HZ: usize = 0x940;
/// Writing 2 asks for the clock, which is then read from the second.
pub const LATCH: usize = 0x944;
pub const LATCHED: usize = 0x948;
/// Who holds it has the camera.
pub const PRIVILEGE: usize = 0xa00;
pub const STREAM_PORT: usize = 0xd00;
/// Bytes of a packet with all headers; its highest bit asks for a packet of that size, as a trial.
pub const PACKET_SIZE: usize = 0xd04;
const PACKET_DELAY: usize = 0xd08;
pub const STREAM_TO: usize = 0xd18;

/// Our own.
const WIDTH: usize = 0xd100;
const HEIGHT: usize = 0xd104;
/// Only [`MONO_8`] is taken.
pub const FORMAT: usize = 0xd108;
/// 1 while pictures are sent.
pub const RUNS: usize = 0xd10c;
/// From picture to picture \[µs\].
pub const PERIOD_US: usize = 0xd110;
const EXPOSURE_US: usize = 0xd114;

/// Grey of 8 bits, by the pixel format naming convention.
pub const MONO_8: u32 = 0x0108_0001;
/// What a discovery answers: the first registers.
pub const DISCOVERED: usize = 0xf8;

/// Registers that a client may write.
const WRITTEN: [usize; 11] = [
    HEARTBEAT_MS,
    LATCH,
    PRIVILEGE,
    STREAM_PORT,
    PACKET_SIZE,
    PACKET_DELAY,
    STREAM_TO,
    FORMAT,
    RUNS,
    PERIOD_US,
    EXPOSURE_US,
];

/// The memory.
pub struct Registers {
    bytes: Vec<u8>,
}

impl Registers {
    /// As they are after power-on.
    pub fn new(width_px: u32, height_px: u32, period_us: u32, address: Ipv4Addr) -> Self {
        let mut registers = Self { bytes: vec![0; END] };
        let xml = description();
        let place = format!("Local:double.xml;{XML_AT:x};{:x}", xml.len());
        for (at, text) in
            [(0x48, "seamtrack"), (0x68, "camera-double"), (0x88, "1"), (0xd8, "1"), (0x200, &place), (XML_AT, &xml)]
        {
            registers.bytes[at..at + text.len()].copy_from_slice(text.as_bytes());
        }
        for (at, number) in [
            (0x0, 0x0001_0002), // version 1.2
            (0x4, 0x8000_0001), // big-endian, UTF-8
            (0xc, 0x0200_0001), // a MAC address of our own
            (0x10, 4),          // an address of its own choice
            (0x14, 4),
            (0x24, u32::from(address)),
            (0x600, 1),     // network interfaces
            (0x904, 1),     // stream channels
            (0x934, 0b111), // resend, writing of memory, several registers at once
            (HEARTBEAT_MS, 3000),
            (CLOCK_HZ, 1_000_000_000),
            (PACKET_SIZE, 1400),
            (WIDTH, width_px),
            (HEIGHT, height_px),
            (FORMAT, MONO_8),
            (PERIOD_US, period_us),
            (EXPOSURE_US, 2000),
        ] {
            registers.set(at, number);
        }
        registers
    }

    /// One register; none beyond the end.
    pub fn read(&self, at: usize) -> Option<u32> {
        Some(u32::from_be_bytes(self.part(at, 4)?.try_into().ok()?))
    }

    /// One register that is there.
    pub fn get(&self, at: usize) -> u32 {
        self.read(at).unwrap_or(0)
    }

    /// A part of the memory; none beyond the end.
    pub fn part(&self, at: usize, count: usize) -> Option<&[u8]> {
        self.bytes.get(at..at.checked_add(count)?)
    }

    /// Sets a register, whoever may write it.
    pub fn set(&mut self, at: usize, number: u32) {
        if let Some(bytes) = self.bytes.get_mut(at..at.saturating_add(4)) {
            bytes.copy_from_slice(&number.to_be_bytes());
        }
    }

    /// Whether a client may write a register.
    pub fn is_written(at: usize) -> bool {
        WRITTEN.contains(&at)
    }
}

/// GenICam's description of our own registers.
fn description() -> String {
    let register = |name: &str, at: usize, mode: &str| {
        format!(
            "<IntReg Name=\"{name}Register\"><Address>{at:#x}</Address><Length>4</Length><AccessMode>{mode}</AccessMode>\
             <pPort>Device</pPort><Sign>Unsigned</Sign><Endianess>BigEndian</Endianess></IntReg>\n"
        )
    };
    let integer = |name: &str, most: u32| {
        format!(
            "<Integer Name=\"{name}\"><pValue>{name}Register</pValue><Min>1</Min><Max>{most}</Max><Inc>1</Inc></Integer>\n"
        )
    };
    let registers = [
        register("Width", WIDTH, "RO"),
        register("Height", HEIGHT, "RO"),
        register("PixelFormat", FORMAT, "RW"),
        register("Run", RUNS, "RW"),
        register("Period", PERIOD_US, "RW"),
        register("Exposure", EXPOSURE_US, "RW"),
    ]
    .concat();
    let features = |names: &[&str]| names.iter().map(|name| format!("<pFeature>{name}</pFeature>")).collect::<String>();
    let image = features(&["Width", "Height", "PixelFormat", "PayloadSize"]);
    let acquisition =
        features(&["AcquisitionMode", "AcquisitionStart", "AcquisitionStop", "AcquisitionFrameRate", "ExposureTime"]);
    let root = features(&["ImageFormatControl", "AcquisitionControl"]);
    let (width, height) = (integer("Width", 65_535), integer("Height", 65_535));
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n\
         <RegisterDescription ModelName=\"camera_double\" VendorName=\"seamtrack\" ToolTip=\"\" StandardNameSpace=\"GEV\" \
         SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" MajorVersion=\"1\" MinorVersion=\"0\" \
         SubMinorVersion=\"0\" ProductGuid=\"00000000-0000-0000-0000-000000000001\" \
         VersionGuid=\"00000000-0000-0000-0000-000000000001\" xmlns=\"http://www.genicam.org/GenApi/Version_1_1\">\n\
         <Category Name=\"Root\">{root}</Category>\n\
         <Category Name=\"ImageFormatControl\">{image}</Category>\n\
         <Category Name=\"AcquisitionControl\">{acquisition}</Category>\n\
         {width}{height}\
         <Enumeration Name=\"PixelFormat\"><EnumEntry Name=\"Mono8\"><Value>{MONO_8}</Value></EnumEntry>\
         <pValue>PixelFormatRegister</pValue></Enumeration>\n\
         <Integer Name=\"PayloadSize\"><pValue>PayloadSizeFormula</pValue></Integer>\n\
         <IntSwissKnife Name=\"PayloadSizeFormula\"><pVariable Name=\"W\">Width</pVariable>\
         <pVariable Name=\"H\">Height</pVariable><Formula>W * H</Formula></IntSwissKnife>\n\
         <Enumeration Name=\"AcquisitionMode\"><EnumEntry Name=\"Continuous\"><Value>0</Value></EnumEntry>\
         <Value>0</Value></Enumeration>\n\
         <Command Name=\"AcquisitionStart\"><pValue>RunRegister</pValue><CommandValue>1</CommandValue></Command>\n\
         <Command Name=\"AcquisitionStop\"><pValue>RunRegister</pValue><CommandValue>0</CommandValue></Command>\n\
         <Float Name=\"AcquisitionFrameRate\"><pValue>Rate</pValue><Min>1</Min><Max>1000</Max></Float>\n\
         <Converter Name=\"Rate\"><FormulaTo>1000000/FROM</FormulaTo><FormulaFrom>1000000/TO</FormulaFrom>\
         <pValue>PeriodRegister</pValue></Converter>\n\
         <Float Name=\"ExposureTime\"><pValue>ExposureFloat</pValue><Min>1</Min><Max>1000000</Max></Float>\n\
         <Converter Name=\"ExposureFloat\"><FormulaTo>FROM</FormulaTo><FormulaFrom>TO</FormulaFrom>\
         <pValue>ExposureRegister</pValue></Converter>\n\
         {registers}<Port Name=\"Device\"/>\n</RegisterDescription>\n"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_description_is_where_the_first_url_says_and_fits() {
        let registers = Registers::new(640, 480, 16_667, Ipv4Addr::LOCALHOST);
        let url = String::from_utf8_lossy(registers.part(0x200, 64).unwrap()).into_owned();
        let mut parts = url.trim_end_matches('\0').split(';').skip(1);
        let mut number = || usize::from_str_radix(parts.next().unwrap(), 16).unwrap();
        let (at, length) = (number(), number());
        let xml = registers.part(at, length).unwrap();
        assert!(xml.starts_with(b"<?xml") && xml.ends_with(b"</RegisterDescription>\n"));
        assert_eq!(
            (registers.read(WIDTH), registers.read(END - 3), registers.read(usize::MAX)),
            (Some(640), None, None)
        );
    }
}
