#include "server/net/hub.hpp"

#include "server/net/compressed_frame.hpp"
#include "server/net/protocol.hpp"
#include "server/render/colour_scale.hpp"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

namespace tetfront {

Hub::Hub(Session& session_, WebFiles files_, AccessPolicy access_, Limits limits_)
    : session(session_), files(std::move(files_)), access(std::move(access_)), limits(limits_) {}

std::size_t Hub::connections_of(const std::string& address) const {
    const auto entry = addresses_.find(address);
    return entry == addresses_.end() ? 0 : entry->second;
}

void Hub::add(const std::shared_ptr<Connection>& connection) {
    if (connections_.insert(connection).second) ++addresses_[connection->address];
}

void Hub::remove(const std::shared_ptr<Connection>& connection) {
    if (connections_.erase(connection) > 0) {
        const auto entry = addresses_.find(connection->address);
        if (--entry->second == 0) addresses_.erase(entry);
    }
    if (done_ && connections_.empty()) done_();
}

void Hub::add_viewer(const std::shared_ptr<Viewer>& viewer) {
    viewers_.insert(viewer);
    if (ready())
        greet(*viewer);
    else
        viewer->outbox.set(Outbox::Slot::progress, progress_);
    broadcast_state();
    viewer->flush();
}

void Hub::remove_viewer(const std::shared_ptr<Viewer>& viewer) {
    if (viewers_.erase(viewer) > 0) {
        const Outbox::Statistics link = viewer->outbox.statistics();
        metrics.frames_sent += link.sent, metrics.frames_dropped += link.dropped;
        show_fields();
        broadcast_state();
    }
    remove(viewer);
}

void Hub::show_fields() {
    std::set<Field> wanted;
    for (const auto& viewer : viewers_)
        if (const Field field = viewer->outbox.kind().field; field != Field::none) wanted.insert(field);
    if (wanted == fields_) return;
    fields_ = wanted;
    session.show_fields(std::move(wanted));
}

std::string Hub::metrics_page() const {
    Gauges now{.connections = connections_.size(),
               .viewers = viewers_.size(),
               .frames_sent = metrics.frames_sent,
               .frames_dropped = metrics.frames_dropped,
               .commands_waiting = session.waiting(),
               .answers_waiting = 0,
               .simulation_busy = session.busy_for()};
    for (const auto& viewer : viewers_) {
        const Outbox::Statistics link = viewer->outbox.statistics();
        now.frames_sent += link.sent, now.frames_dropped += link.dropped;
        now.answers_waiting += viewer->outbox.waiting();
    }
    return tetfront::metrics_page(metrics, now, state_ ? &*state_ : nullptr);
}

std::string Hub::stalled() const {
    const double busy = session.busy_for();
    if (busy * 1000 < static_cast<double>(limits.stall.count())) return "";
    return "the simulation thread has been at one thing for " + std::to_string(static_cast<long>(busy)) + " s";
}

Hub::Refusal Hub::snapshot(const SnapshotQuery& query, SnapshotPainter::Done done) {
    using namespace std::chrono_literals;
    if (!ready()) return Refusal::not_ready;
    const auto now = std::chrono::steady_clock::now();
    // One at a time, and not without a pause: pictures must not starve the simulation.
    if (*painting_ || now - last_snapshot_ < 100ms) return Refusal::busy;
    last_snapshot_ = now;
    *painting_ = true;
    View view = make_view(query.view, *model_->frame_model, query.width, query.height);
    view.floor = model_->floor;
    const std::string& title = model_->scene.title.empty() ? model_->scene.name : model_->scene.title;
    auto finish = [painting = painting_, done = std::move(done)](SnapshotPainter::Result result) {
        *painting = false;
        done(std::move(result));
    };
    session.capture(field_of(view.colouring), [this, view, title, finish](std::shared_ptr<const Frame> frame) {
        if (!frame) return finish({"", "the simulation has ended or failed"});
        painter_.submit({std::move(frame), view, title}, finish);
    });
    return Refusal::none;
}

void Hub::shut_down(std::function<void()> done) {
    done_ = std::move(done);
    if (connections_.empty()) return done_();
    for (const auto& connection : std::set(connections_)) connection->shut_down();
}

void Hub::on_progress(const std::string& what, double fraction) {
    if (std::exchange(stage_, what) != what) spdlog::info("building the model: {}", what);
    progress_ = share(progress_event(what, fraction, remaining_.of(what, fraction)));
    set_all(Outbox::Slot::progress, progress_);
}

/// Of a first or of another scene: viewers are greeted when its first frame and state are there.
void Hub::on_model(std::shared_ptr<const SessionModel> model) {
    if (model_) spdlog::info("now serving {}", model->scene.name);
    model_ = std::move(model);
    ++generation_;
    frame_ = nullptr;
    coloured_.clear();
    state_.reset();
    settings_ = nullptr;
    for (const auto& viewer : viewers_) viewer->outbox.restart();
    if (const Shots early = std::exchange(early_, {}); early.frame && early.frame->model == model_->frame_model) on_frame(early);
}

void Hub::on_frame(const Shots& shots) {
    if (!model_ || shots.frame->model != model_->frame_model) {
        early_ = shots;
        return;
    }
    frame_ = shots.frame;
    coloured_ = shots.coloured;
    if (!ready() || viewers_.empty()) return;
    const auto present = moment();
    for (const auto& viewer : viewers_) {
        viewer->outbox.show(present);
        viewer->flush();
    }
}

void Hub::on_state(const SessionState& state) {
    if (!model_) return;
    const bool was_ready = ready();
    const bool was_recording = std::exchange(recording_active_, state.recording.active);
    state_ = state;
    if (!state.recording.problem.empty() && was_recording && !state.recording.active) {
        spdlog::warn("{}: {}", state.recording.name, state.recording.problem);
        broadcast(log_event("warning", state.recording.name + ": " + state.recording.problem));
    }
    const SharedBytes settings = share(settings_event(state));
    if (!settings_ || *settings_ != *settings) {
        settings_ = settings;
        set_all(Outbox::Slot::settings, settings_);
    }
    const auto now = std::chrono::steady_clock::now();
    if (was_recording != state.recording.active || (state.recording.active && now - last_recording_ >= std::chrono::seconds(1))) {
        last_recording_ = now;
        recording_ = share(recording_event(state.recording));
        set_all(Outbox::Slot::recording, recording_);
    }
    if (!was_ready && ready())
        for (const auto& viewer : viewers_) greet(*viewer);
    broadcast_state();
}

void Hub::greet(Viewer& viewer) {
    const Session::Settings& settings = session.settings();
    std::vector<std::string_view> capabilities = {"acknowledge", "colouring", "compress"};
    if (!model_->recorded) capabilities.emplace_back("edit");
    if (settings.library.has_scenes()) capabilities.emplace_back("load");
    if (!model_->recorded && settings.library.keeps()) {
        capabilities.emplace_back("record");
        capabilities.emplace_back("save");
    }
    viewer.push(hello_event(*model_, *state_, generation_,
                            {.message_bytes = limits.message_bytes,
                             .messages_per_second = limits.messages_per_second,
                             .recording_bytes = settings.recording_bytes},
                            capabilities));
    viewer.outbox.set(Outbox::Slot::progress, nullptr);
    viewer.outbox.set(Outbox::Slot::settings, settings_);
    viewer.outbox.set(Outbox::Slot::recording, recording_);
    viewer.outbox.show(moment());
    viewer.flush();
}

void Hub::set_all(Outbox::Slot slot, const SharedBytes& text) {
    for (const auto& viewer : viewers_) {
        viewer->outbox.set(slot, text);
        viewer->flush();
    }
}

void Hub::broadcast(const std::string& text) {
    for (const auto& viewer : std::set(viewers_)) {  // one that does not read is closed
        viewer->push(text);
        viewer->flush();
    }
}

void Hub::broadcast_state() {
    if (!ready() || viewers_.empty()) return;
    const auto now = Outbox::Clock::now();
    for (const auto& viewer : viewers_) {
        const Outbox::Statistics link = viewer->outbox.statistics();
        if (now - viewer->last_link < std::chrono::seconds(1) || link.sent == viewer->link_sent) continue;
        viewer->last_link = now;
        viewer->link_sent = link.sent;
        viewer->outbox.set(Outbox::Slot::link, share(link_event(link)));
    }
    set_all(Outbox::Slot::state, share(state_event(*state_, viewers_.size())));
}

/// Encodes each kind when the first viewer wants it, compressed ones from the others. Belongs to the moment, so kinds that
/// nobody wants cost nothing.
std::function<SharedBytes(FrameKind)> Hub::frame_encoder() {
    auto encoded = std::make_shared<std::map<FrameKind, SharedBytes>>();
    return [this, plain = frame_, coloured = coloured_, generation = generation_, sequence = sequence_, encoded](FrameKind kind) {
        const auto shot = std::ranges::find(coloured, kind.field, [](const auto& frame) { return frame->field; });
        const Frame& frame = shot == coloured.end() ? *plain : **shot;
        const auto once = [&](FrameKind wanted, const auto& make) -> const SharedBytes& {
            SharedBytes& bytes = (*encoded)[wanted];
            if (bytes) return bytes;
            const auto start = std::chrono::steady_clock::now();
            bytes = share(make());
            ++metrics.frames_encoded;
            metrics.encode_seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
            return bytes;
        };
        const SharedBytes& bytes = once({frame.field, false}, [&] { return encode_frame(frame, generation, sequence); });
        return kind.compressed ? once({frame.field, true}, [&] { return compress_frame(*bytes); }) : bytes;
    };
}

/// The present frame's messages; model and topology are encoded only when they have changed.
std::shared_ptr<const Moment> Hub::moment() {
    if (encoded_frame_ == frame_) return encoded_;
    const bool same_model = encoded_ && encoded_->generation == generation_;
    auto next = std::make_shared<Moment>();
    next->generation = generation_;
    next->epoch = frame_->topology->epoch;
    next->sequence = ++sequence_;
    next->model = same_model ? encoded_->model : share(encode_model(*frame_->model, generation_));
    next->topology = same_model && encoded_frame_->topology == frame_->topology
                         ? encoded_->topology
                         : share(encode_topology(*frame_->topology, frame_->front_positions.size(), generation_));
    next->frame = frame_encoder();
    encoded_ = std::move(next);
    encoded_frame_ = frame_;
    return encoded_;
}

}  // namespace tetfront
