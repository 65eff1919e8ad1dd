use kiloray_core::node::{Clock, Time};
use std::cell::{Cell, RefCell};
use std::convert::Infallible;
use std::future::poll_fn;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::{Context, Poll, Wake, Waker};

/// By then all is done: a minute.
const TOO_LONG: Time = Time(60_000_000_000);

/// A clock that goes on when nothing else does.
#[derive(Debug, Default)]
pub(crate) struct TestClock {
    now: Cell<Time>,
    waiting: RefCell<Vec<(Time, Waker)>>,
}

impl Clock for TestClock {
    fn now(&self) -> Time {
        self.now.get()
    }

    async fn wait(&self, until: Time) {
        poll_fn(|cx| {
            if self.now.get() >= until {
                return Poll::Ready(());
            }
            self.waiting.borrow_mut().push((until, cx.waker().clone()));
            Poll::Pending
        })
        .await;
    }
}

impl TestClock {
    /// Goes on to the next moment that somebody waits for.
    fn go_on(&self) {
        let mut waiting = self.waiting.borrow_mut();
        let next = waiting.iter().map(|(until, _)| *until).min();
        let next = next.filter(|next| *next < TOO_LONG).expect("an end, or somebody awake");
        self.now.set(next);
        waiting.extract_if(.., |(until, _)| *until <= next).for_each(|(_, waker)| waker.wake());
    }
}

#[derive(Debug, Default)]
struct Woken(AtomicBool);

impl Wake for Woken {
    fn wake(self: Arc<Self>) {
        self.0.store(true, Ordering::Relaxed);
    }
}

type Task<'t> = Pin<Box<dyn Future<Output = Infallible> + 't>>;

/// Tasks that are polled when they were woken, in turn.
pub(crate) struct Tasks<'t> {
    tasks: Vec<(Task<'t>, Arc<Woken>)>,
    clock: &'t TestClock,
}

impl<'t> Tasks<'t> {
    pub(crate) const fn new(clock: &'t TestClock) -> Self {
        Self { tasks: Vec::new(), clock }
    }

    pub(crate) fn add(&mut self, task: impl Future<Output = Infallible> + 't) {
        self.tasks.push((Box::pin(task), Arc::new(Woken(true.into()))));
    }

    pub(crate) fn run_until(&mut self, done: impl Fn() -> bool) {
        while !done() {
            let mut any = false;
            for (task, woken) in &mut self.tasks {
                if woken.0.swap(false, Ordering::Relaxed) {
                    any = true;
                    let waker = Waker::from(Arc::clone(woken));
                    let Poll::Pending = task.as_mut().poll(&mut Context::from_waker(&waker));
                }
            }
            if !any {
                self.clock.go_on();
            }
        }
    }
}
