//! Files of other kinds, recognised by their first bytes: a person who opened the wrong file is
//! told what it is.
//!
//! In: the first bytes of a file. Out: what it is, in words, and what can be done with it, if
//! anything.
//!
//! Sources: the formats' own specifications; the list of file signatures of `file` (libmagic).

/// Bytes that are enough to recognise each kind.
pub const ENOUGH: usize = 512;

/// A file that is recognised, but not read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownFile {
    /// What it is: `a JPEG picture`.
    pub what: &'static str,
    /// What can be done with it; may be empty.
    pub advice: &'static str,
}

/// Offset of the signature, the signature, what it is, advice.
type Row = (usize, &'static [u8], &'static str, &'static str);

const UNPACK: &str = "unpack it, and open what is in it";
const BAG_IN_SQLITE: &str = "if it is a bag of ROS 2 (.db3), make an MCAP file of it: `ros2 bag convert`, or \
    `rosbags-convert --src BAG --dst NEW --dst-storage mcap`";
const POINTS: &str = "points of a 3D lidar are not read; scans of a 2D lidar are";

const SIGNATURES: [Row; 43] = [
    (0, b"\xff\xd8\xff", "a JPEG picture", ""),
    (
        0,
        b"\x89PNG\r\n\x1a\n",
        "a PNG picture",
        "a map of ROS is opened together with its YAML file",
    ),
    (0, b"GIF8", "a GIF picture", ""),
    (0, b"II*\0", "a TIFF picture", ""),
    (0, b"MM\0*", "a TIFF picture", ""),
    (8, b"WEBP", "a WebP picture", ""),
    (8, b"WAVE", "a sound (WAV)", ""),
    (8, b"AVI ", "a film (AVI)", ""),
    (
        0,
        b"PK\x03\x04",
        "a ZIP archive (or a document that is one: DOCX, XLSX, ODT, JAR)",
        UNPACK,
    ),
    (0, b"PK\x05\x06", "a ZIP archive, and an empty one", ""),
    (0, b"7z\xbc\xaf\x27\x1c", "a 7-Zip archive", UNPACK),
    (0, b"Rar!\x1a\x07", "a RAR archive", UNPACK),
    (0, b"\xfd7zXZ\0", "a file packed by xz", UNPACK),
    (0, b"BZh", "a file packed by bzip2", UNPACK),
    (0, b"\x28\xb5\x2f\xfd", "a file packed by zstd", UNPACK),
    (0, b"\x04\x22\x4d\x18", "a file packed by lz4", UNPACK),
    (257, b"ustar", "a TAR archive", UNPACK),
    (0, b"%PDF-", "a PDF document", ""),
    (0, b"%!PS", "a PostScript document", ""),
    (0, b"{\\rtf", "an RTF document", ""),
    (
        0,
        b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1",
        "an old document of Microsoft Office",
        "",
    ),
    (0, b"\x7fELF", "a program (ELF)", ""),
    (0, b"MZ\x90\0", "a program for Windows", ""),
    (0, b"\xcf\xfa\xed\xfe", "a program for macOS", ""),
    (
        0,
        b"\xca\xfe\xba\xbe",
        "a Java class, or a program for macOS",
        "",
    ),
    (0, b"\0asm", "a WebAssembly module", ""),
    (
        0,
        b"SQLite format 3\0",
        "a database (SQLite)",
        BAG_IN_SQLITE,
    ),
    (0, b"\x89HDF\r\n\x1a\n", "an HDF5 file", ""),
    (0, b"\x93NUMPY", "an array of NumPy", ""),
    (0, b"MATLAB 5.0", "a file of MATLAB", ""),
    (0, b"ply\n", "a PLY model", POINTS),
    (0, b"# .PCD", "a point cloud (PCD)", POINTS),
    (0, b"LASF", "a point cloud (LAS)", POINTS),
    (0, b"ASTM-E57", "a point cloud (E57)", POINTS),
    (
        0,
        b"RRF2",
        "a recording of Rerun",
        "the bridge's own recording (.mcap) is read",
    ),
    (4, b"ftyp", "a film or a picture (MP4, MOV, HEIC)", ""),
    (0, b"\x1aE\xdf\xa3", "a film (Matroska, WebM)", ""),
    (0, b"OggS", "a sound or a film (Ogg)", ""),
    (0, b"ID3\x03", "a sound (MP3)", ""),
    (0, b"fLaC", "a sound (FLAC)", ""),
    (0, b"\xd4\xc3\xb2\xa1", "a capture of a network (pcap)", ""),
    (
        0,
        b"\x0a\x0d\x0d\x0a",
        "a capture of a network (pcapng)",
        "",
    ),
    (
        0,
        b"%YAML",
        "a YAML file",
        "of a map of ROS, its image is opened with it",
    ),
];

/// Texts that are recognised by how they begin, after blanks, in small letters.
const TEXTS: [(&str, &str, &str); 9] = [
    (
        "<!doctype html",
        "an HTML page",
        "perhaps the page of a download, and not the file itself",
    ),
    (
        "<html",
        "an HTML page",
        "perhaps the page of a download, and not the file itself",
    ),
    ("<?xml", "an XML file", "of drawings, SVG is read"),
    (
        "<svg",
        "a drawing (SVG)",
        "as a floor plan it is opened alone",
    ),
    ("{", "a JSON file, and no world of slamlab", ""),
    (
        "rosbag2_bagfile_information",
        "the description of a ROS 2 bag",
        "open the .mcap file beside it",
    ),
    (
        "version https://git-lfs",
        "a pointer of Git LFS",
        "the file itself comes by `git lfs pull`",
    ),
    ("#!/", "a script", ""),
    ("-----begin ", "a key or a certificate", ""),
];

/// `None` if the file is not recognised: it may be one of ours.
#[must_use]
pub fn known_file(begun: &[u8]) -> Option<KnownFile> {
    let has = |(at, sign, ..): &&Row| begun.get(*at..).is_some_and(|rest| rest.starts_with(sign));
    if let Some((_, _, what, advice)) = SIGNATURES.iter().find(has) {
        return Some(KnownFile { what, advice });
    }
    let text = begun
        .strip_prefix(b"\xef\xbb\xbf")
        .unwrap_or(begun)
        .trim_ascii_start();
    let begins = |(sign, ..): &&(&str, _, _)| {
        let start = text.get(..sign.len());
        start.is_some_and(|start| start.eq_ignore_ascii_case(sign.as_bytes()))
    };
    let (_, what, advice) = TEXTS.iter().find(begins)?;
    Some(KnownFile { what, advice })
}

impl std::fmt::Display for KnownFile {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { what, advice } = self;
        match *advice {
            "" => write!(f, "this is {what}"),
            advice => write!(f, "this is {what}: {advice}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(begun: &[u8], expected: &str) {
        assert_eq!(known_file(begun).map(|known| known.what), Some(expected));
    }

    #[test]
    fn wrong_files_are_named() {
        check(b"\xff\xd8\xff\xe0\x00\x10JFIF", "a JPEG picture");
        check(b"RIFF\x10\0\0\0WEBPVP8 ", "a WebP picture");
        check(b"\x7fELF\x02\x01\x01", "a program (ELF)");
        check(b"%PDF-1.7\n", "a PDF document");
        check(b"\xef\xbb\xbf \r\n<!DOCTYPE HTML>", "an HTML page");
        check(b"<HTML lang=en>", "an HTML page");
        let mut tar = [0; ENOUGH];
        tar[257..262].copy_from_slice(b"ustar");
        check(&tar, "a TAR archive");
        let bag = known_file(b"SQLite format 3\0").unwrap().to_string();
        assert!(
            bag.contains("database") && bag.contains("--dst-storage mcap"),
            "{bag}"
        );
    }

    #[test]
    fn what_is_read_here_is_not_called_something_else() {
        let ours: [&[u8]; 9] = [
            b"# CARMEN\nFLASER 3",
            b"PARAM robot 1",
            b"12 13 14 500",
            b"S_t:1.5_d:2_q:3|",
            b"t_s,x_m,y_m",
            b"\x89MCAP0\r\n",
            b"\x1f\x8b\x08",
            b"#ROSBAG V2.0\n",
            b"",
        ];
        for begun in ours {
            assert_eq!(known_file(begun), None, "{begun:?}");
        }
    }

    #[test]
    fn each_row_is_found_by_its_own_signature_and_says_what_it_is() {
        for (at, sign, what, _) in SIGNATURES {
            let mut bytes = vec![0; at];
            bytes.extend_from_slice(sign);
            check(&bytes, what);
        }
        for (sign, what, _) in TEXTS {
            check(format!("\n {sign} more").as_bytes(), what);
        }
    }
}
