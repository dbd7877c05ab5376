//! A page to look at a live run: picture, state, numbers, the last minute. It reads only; with a token it may reset and stop.
//!
//! One thread with one runtime. Nobody waits for whoever looks: the tracker copies a picture only when one was asked for, and a
//! client that reads slowly loses events and pictures. hyper is enough for five addresses; axum would bring twice as many crates.

mod html;
mod http;
mod view;

use std::collections::VecDeque;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use hyper::body::Bytes;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::{TokioIo, TokioTimer};
use serde_json::{Value, json};
use tokio::sync::{Mutex, mpsc};
use tokio::time::MissedTickBehavior;

use super::camera::LiveClock;
use super::robot::Shared;
use super::{Correction, LiveConfig, LiveError};
pub use view::{Seen, Shown, View};

/// From event to event. Chosen: what an eye follows.
const EVENT: Duration = Duration::from_millis(100);
/// Events that are remembered: a minute.
const MINUTE: usize = 600;
/// Events that may wait for a client; what is more is lost to it. Chosen: half a second.
const WAITING: usize = 5;
/// Connections at a time. Chosen: some browsers, each with its events and pictures.
const MOST_CONNECTIONS: usize = 24;
/// How long a client may take to ask. Chosen.
const ASKING: Duration = Duration::from_secs(10);

/// The page of a run, before it is served.
pub struct Page {
    listener: Option<TcpListener>,
    token: Option<String>,
    view: Option<Arc<View>>,
}

impl Page {
    /// Listens where the configuration says, if it does.
    pub fn open(config: &LiveConfig) -> Result<Self, LiveError> {
        let Some(address) = config.page else { return Ok(Self { listener: None, token: None, view: None }) };
        let port = |source| LiveError::Port { address, source };
        let listener = TcpListener::bind(address).map_err(port)?;
        listener.set_nonblocking(true).map_err(port)?;
        Ok(Self { listener: Some(listener), token: config.page_token.clone(), view: Some(Arc::default()) })
    }

    /// Where the tracker leaves what is shown, if somebody may look.
    pub fn view(&self) -> Option<Arc<View>> {
        self.view.clone()
    }

    /// Serves until the run ends.
    ///
    /// # Errors
    /// When the runtime or the port cannot be used.
    pub fn serve(self, shared: &Arc<Shared>, clock: LiveClock) -> std::io::Result<()> {
        let (Some(listener), Some(view)) = (self.listener, self.view) else { return Ok(()) };
        let site = Arc::new(Site {
            shared: Arc::clone(shared),
            clock,
            view,
            token: self.token,
            picture: Mutex::default(),
            listeners: Mutex::default(),
        });
        tokio::runtime::Builder::new_current_thread().enable_all().build()?.block_on(site.serve(listener))
    }
}

/// What every request needs.
struct Site {
    shared: Arc<Shared>,
    clock: LiveClock,
    view: Arc<View>,
    token: Option<String>,
    /// The last picture as JPEG: several browsers share it. Held while one is waited for, so that they wait together.
    picture: Mutex<Option<(std::time::Instant, Bytes)>>,
    listeners: Mutex<Listeners>,
}

/// Who listens to events, and what newcomers are told first.
#[derive(Default)]
struct Listeners {
    clients: Vec<mpsc::Sender<Bytes>>,
    minute: VecDeque<Value>,
}

impl Site {
    async fn serve(self: Arc<Self>, listener: TcpListener) -> std::io::Result<()> {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        let mut tick = tokio::time::interval(EVENT);
        tick.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let connections = Arc::new(());
        while !self.shared.is_ending() {
            tokio::select! {
                _ = tick.tick() => self.tell().await,
                accepted = listener.accept() => match accepted {
                    // Its address is of no use; whoever is one too many is hung up on.
                    Ok((stream, _)) if Arc::strong_count(&connections) <= MOST_CONNECTIONS => {
                        let (site, counted) = (Arc::clone(&self), Arc::clone(&connections));
                        tokio::spawn(async move {
                            let _counted = counted;
                            let handle = service_fn(move |request| http::answer(Arc::clone(&site), request));
                            let mut http = http1::Builder::new();
                            let http = http.timer(TokioTimer::new()).header_read_timeout(ASKING);
                            // A client that goes or talks nonsense is no concern of ours.
                            let _done = http.serve_connection(TokioIo::new(stream), handle).await;
                        });
                    }
                    Ok(_) => {}
                    // A client that left before it was accepted, or no free file: the next one may be luckier.
                    Err(_) => tokio::time::sleep(EVENT).await,
                },
            }
        }
        Ok(())
    }

    /// One event for all who listen.
    async fn tell(&self) {
        let now = self.now();
        let event = Bytes::from(format!("event: now\ndata: {now}\n\n"));
        let mut listeners = self.listeners.lock().await;
        listeners.clients.retain(|client| !client.is_closed());
        // What does not fit is lost to that client.
        listeners.clients.iter().for_each(|client| drop(client.try_send(event.clone())));
        if listeners.minute.len() == MINUTE {
            listeners.minute.pop_front();
        }
        let short = json!({"total_mm": now["total_mm"], "remaining_mm": now["remaining_mm"]});
        listeners.minute.push_back(short);
    }

    /// A new listener, its first event waiting.
    async fn listen(&self) -> mpsc::Receiver<Bytes> {
        let (client, events) = mpsc::channel(WAITING);
        let mut listeners = self.listeners.lock().await;
        let minute = json!(listeners.minute);
        drop(client.try_send(Bytes::from(format!("event: minute\ndata: {minute}\n\n"))));
        listeners.clients.push(client);
        events
    }

    fn now(&self) -> Value {
        let (told, seen) = (self.shared.last(), self.view.seen());
        let answer = told.as_ref().map(|told| &told.answer);
        let is_step = answer.is_some_and(|answer| matches!(answer.correction, Correction::Step(_)));
        let age_ms = answer.and_then(|answer| answer.age_s).map(|age_s| age_s * 1e3);
        json!({
            "time_s": self.clock.now_s(),
            "state": answer.map_or("WAIT", |answer| answer.state.name()),
            "why": answer.map_or("no robot yet", |answer| answer.why.name()),
            "path_mm": answer.map(|answer| answer.pose.path_mm),
            "lateral_mm": answer.map(|answer| answer.pose.lateral_mm),
            // What is not steered to is not shown as if it were.
            "total_mm": answer.filter(|_| is_step).map(|answer| answer.total_mm),
            "remaining_mm": answer.filter(|_| is_step).and_then(|answer| answer.remaining_mm),
            "age_ms": age_ms, "cycle": told.map_or(0, |told| told.cycle), "late": told.map_or(0, |told| told.late),
            "gap_mm": seen.gap_mm, "latency_ms": seen.latency_ms, "step_ms": seen.step_ms,
            "frames": seen.by_status, "passed_over": seen.passed_over, "holes": seen.holes,
        })
    }
}
