//! `meshcolor health`: asks a running service, for containers without a shell.

use std::io::{Write, stdout};
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::time::Duration;

use anyhow::Context;

use super::Outcome;
use super::serve::DEFAULT_BIND;

#[derive(clap::Args)]
pub struct Arguments {
    /// The address that the service was told to listen on
    #[arg(long, env = "MESHCOLOR_BIND", value_name = "ADDRESS", default_value = DEFAULT_BIND)]
    bind: SocketAddr,
}

pub fn run(arguments: &Arguments) -> anyhow::Result<Outcome> {
    let url = format!("http://{}/readyz", reachable(arguments.bind));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let (status, text) = runtime
        .block_on(async {
            let client = reqwest::Client::builder().no_proxy().timeout(Duration::from_secs(5)).build()?;
            let response = client.get(&url).send().await?;
            let status = response.status();
            anyhow::Ok((status, response.text().await?))
        })
        .with_context(|| format!("{url} does not answer"))?;
    writeln!(stdout(), "{text}")?;
    Ok(if status.is_success() { Outcome::Fine } else { Outcome::Failed })
}

/// "All addresses" is where one listens; one asks the machine itself.
fn reachable(bind: SocketAddr) -> SocketAddr {
    let ip = match bind.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => Ipv4Addr::LOCALHOST.into(),
        IpAddr::V6(ip) if ip.is_unspecified() => Ipv6Addr::LOCALHOST.into(),
        ip => ip,
    };
    SocketAddr::new(ip, bind.port())
}
