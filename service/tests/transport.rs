//! Abuse below HTTP: connections that do not speak, speak slowly or lie.

mod support;

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::process::Command;
use std::time::Duration;

use support::{Folder, Service};

/// Sends bytes and reads until the service closes.
fn exchange(service: &Service, bytes: &[u8]) -> String {
    let mut stream = TcpStream::connect(service.address()).unwrap();
    // Only there so that a service which never closes fails the test instead of hanging it.
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let _ = stream.write_all(bytes);
    let mut answer = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        match stream.read(&mut buffer) {
            Ok(0) => break,
            Ok(count) => answer.extend_from_slice(&buffer[..count]),
            Err(error) if error.kind() == ErrorKind::ConnectionReset => break,
            Err(error) => panic!("the service keeps the connection: {error}"),
        }
    }
    String::from_utf8_lossy(&answer).into_owned()
}

#[test]
fn silent_and_slow_connections_are_closed() {
    let data = Folder::new();
    let service = Service::start(data.root(), &["--header-read-timeout", "1", "--body-idle-timeout", "1"]);
    assert_eq!(exchange(&service, b""), "");
    exchange(&service, b"GET /livez HTTP/1.1\r\nHost:");
    let start =
        b"POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Type: model/obj\r\nContent-Length: 1000\r\n\r\nv";
    let answer = exchange(&service, start);
    assert!(answer.starts_with("HTTP/1.1 408") && answer.contains("upload_too_slow"), "{answer}");
}

#[test]
fn connections_over_the_limit_wait_their_turn() {
    let data = Folder::new();
    let service = Service::start(data.root(), &["--max-connections", "2", "--header-read-timeout", "1"]);
    let idle: Vec<_> = (0..4).map(|_| TcpStream::connect(service.address()).unwrap()).collect();
    let answer = exchange(&service, b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    drop(idle);
}

#[test]
fn shapes_that_confuse_proxies_are_refused() {
    let data = Folder::new();
    let service = Service::start(data.root(), &["--header-read-timeout", "1"]);
    let long = format!("GET /livez HTTP/1.1\r\nHost: x\r\nX: {}\r\n\r\n", "x".repeat(1 << 20));
    let wrong: [&[u8]; 5] = [
        b"GET /livez\r\n\r\n",
        b"POST /v1/jobs HTTP/1.1\r\nHost: x\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\nabcd",
        b"POST /v1/jobs HTTP/1.1\r\nHost: x\r\nTransfer-Encoding: x\r\n\r\n",
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
        long.as_bytes(),
    ];
    for bytes in wrong {
        let answer = exchange(&service, bytes);
        let is_refused = answer.is_empty() || answer.starts_with("HTTP/1.1 4");
        assert!(is_refused, "{:?}: {answer}", String::from_utf8_lossy(&bytes[..bytes.len().min(60)]));
    }
    let answer = exchange(&service, b"GET /livez HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
}

#[test]
fn a_signal_stops_the_service_cleanly() {
    let data = Folder::new();
    let mut service = Service::start(data.root(), &["--shutdown-grace", "1"]);
    let idle = TcpStream::connect(service.address()).unwrap();
    let killed = Command::new("kill").args(["-TERM", &service.child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    assert_eq!(service.child.wait().unwrap().code(), Some(0));
    drop(idle);
}
