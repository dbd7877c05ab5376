//! Addresses of the page and what they answer.

use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use hyper::body::{Body, Bytes, Frame, Incoming, SizeHint};
use hyper::header::{AUTHORIZATION, CACHE_CONTROL, CONTENT_TYPE, HOST, HeaderMap};
use hyper::{Method, Request, Response, StatusCode};
use tokio::sync::mpsc;

use super::{Site, html};
use crate::live::wire::Command;

/// A picture this young is shared by all who ask. Chosen: 20 pictures a second at most.
const YOUNG: Duration = Duration::from_millis(50);
/// How long a picture is waited for, how long the first one, and how often somebody looks. Chosen.
const PATIENCE: Duration = Duration::from_secs(1);
const FIRST: Duration = Duration::from_secs(5);
const LOOK: Duration = Duration::from_millis(5);

/// A whole answer, or events without end.
pub enum Answer {
    /// All of it.
    Whole(Option<Bytes>),
    /// One after the other.
    Events(mpsc::Receiver<Bytes>),
}

impl Body for Answer {
    type Data = Bytes;
    type Error = Infallible;

    fn poll_frame(self: Pin<&mut Self>, cx: &mut Context<'_>) -> Poll<Option<Result<Frame<Bytes>, Infallible>>> {
        match self.get_mut() {
            Self::Whole(bytes) => Poll::Ready(bytes.take().map(|bytes| Ok(Frame::data(bytes)))),
            Self::Events(events) => events.poll_recv(cx).map(|event| event.map(|bytes| Ok(Frame::data(bytes)))),
        }
    }

    fn is_end_stream(&self) -> bool {
        matches!(self, Self::Whole(None))
    }

    fn size_hint(&self) -> SizeHint {
        match self {
            Self::Whole(bytes) => SizeHint::with_exact(bytes.as_ref().map_or(0, |bytes| bytes.len() as u64)),
            Self::Events(_) => SizeHint::default(),
        }
    }
}

fn whole(status: StatusCode, kind: &'static str, bytes: impl Into<Bytes>) -> Response<Answer> {
    let mut response = Response::new(Answer::Whole(Some(bytes.into())));
    *response.status_mut() = status;
    finished(response, kind)
}

fn finished(mut response: Response<Answer>, kind: &'static str) -> Response<Answer> {
    let headers = response.headers_mut();
    headers.insert(CONTENT_TYPE, hyper::header::HeaderValue::from_static(kind));
    headers.insert(CACHE_CONTROL, hyper::header::HeaderValue::from_static("no-store"));
    headers.insert("x-content-type-options", hyper::header::HeaderValue::from_static("nosniff"));
    response
}

fn refused(status: StatusCode, words: &'static str) -> Response<Answer> {
    whole(status, "text/plain; charset=utf-8", words)
}

/// Answers one request.
pub async fn answer(site: Arc<Site>, request: Request<Incoming>) -> Result<Response<Answer>, Infallible> {
    if !is_host_ours(request.headers()) {
        return Ok(refused(StatusCode::FORBIDDEN, "ask by address or as localhost\n"));
    }
    let (is_get, is_post) = (request.method() == Method::GET, request.method() == Method::POST);
    Ok(match request.uri().path() {
        "/" if is_get => whole(StatusCode::OK, "text/html; charset=utf-8", html::page(site.token.is_some())),
        "/events" if is_get => finished(Response::new(Answer::Events(site.listen().await)), "text/event-stream"),
        "/picture.jpg" if is_get => match site.picture().await {
            Some(jpeg) => whole(StatusCode::OK, "image/jpeg", jpeg),
            None => whole(StatusCode::NO_CONTENT, "image/jpeg", ""),
        },
        "/reset" if is_post => site.order(request.headers(), Command::Reset),
        "/stop" if is_post => site.order(request.headers(), Command::Stop),
        "/" | "/events" | "/picture.jpg" | "/reset" | "/stop" => {
            refused(StatusCode::METHOD_NOT_ALLOWED, "this address is asked otherwise\n")
        }
        _ => refused(StatusCode::NOT_FOUND, "there is no such address\n"),
    })
}

/// Whether the name we are called by is an address or localhost: else a page of somebody else whose name was led to this address
/// (DNS rebinding) could read along.
fn is_host_ours(headers: &HeaderMap) -> bool {
    let host = headers.get(HOST).and_then(|host| host.to_str().ok()).unwrap_or("");
    let is_address = host.parse::<SocketAddr>().is_ok() || host.trim_matches(['[', ']']).parse::<IpAddr>().is_ok();
    let name = host.rsplit_once(':').map_or(host, |(name, _)| name);
    is_address || name.eq_ignore_ascii_case("localhost")
}

impl Site {
    /// The newest picture as JPEG; the last one if none comes.
    async fn picture(&self) -> Option<Bytes> {
        let mut last = self.picture.lock().await;
        if let Some((_, jpeg)) = last.as_ref().filter(|(made, _)| made.elapsed() < YOUNG) {
            return Some(jpeg.clone());
        }
        // One that was left long ago is not new.
        drop(self.view.take());
        self.view.want();
        let began = Instant::now();
        let patience = if last.is_some() { PATIENCE } else { FIRST };
        while began.elapsed() < patience {
            tokio::time::sleep(LOOK).await;
            if let Some(jpeg) = self.view.take().and_then(|shown| shown.jpeg()) {
                *last = Some((Instant::now(), Bytes::from(jpeg)));
                break;
            }
        }
        last.as_ref().map(|(_, jpeg)| jpeg.clone())
    }

    /// Gives an order to the guide, if the token is right.
    fn order(&self, headers: &HeaderMap, command: Command) -> Response<Answer> {
        let given = headers.get(AUTHORIZATION).and_then(|value| value.to_str().ok()?.strip_prefix("Bearer "));
        match (&self.token, given) {
            (Some(token), Some(given)) if is_same(token.as_bytes(), given.as_bytes()) => {
                self.shared.orders.ask(command);
                whole(StatusCode::OK, "text/plain; charset=utf-8", "done\n")
            }
            _ => refused(StatusCode::FORBIDDEN, "orders need the token of live.toml (page_token)\n"),
        }
    }
}

/// Compares in a time that does not tell where they differ.
fn is_same(a: &[u8], b: &[u8]) -> bool {
    a.len() == b.len() && a.iter().zip(b).fold(0, |sum, (a, b)| sum | (a ^ b)) == 0
}
