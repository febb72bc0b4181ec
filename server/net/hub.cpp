#include "server/net/hub.hpp"

#include "server/net/protocol.hpp"
#include "server/render/colour_scale.hpp"

#include <utility>

#include <spdlog/spdlog.h>

namespace tetfront {

Hub::Hub(Session& session_, WebFiles files_, AccessPolicy access_)
    : session(session_), files(std::move(files_)), access(std::move(access_)) {}

void Hub::add(const std::shared_ptr<Connection>& connection) { connections_.insert(connection); }

void Hub::remove(const std::shared_ptr<Connection>& connection) {
    connections_.erase(connection);
    if (done_ && connections_.empty()) done_();
}

void Hub::add_viewer(const std::shared_ptr<Viewer>& viewer) {
    viewers_.insert(viewer);
    if (ready())
        greet(*viewer);
    else
        viewer->outbox.set_progress(progress_);
    broadcast_state();
    viewer->flush();
}

void Hub::remove_viewer(const std::shared_ptr<Viewer>& viewer) {
    if (viewers_.erase(viewer) > 0) broadcast_state();
    remove(viewer);
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
    for (const auto& viewer : viewers_) {
        viewer->outbox.set_progress(progress_);
        viewer->flush();
    }
}

void Hub::on_model(std::shared_ptr<const SessionModel> model) { model_ = std::move(model); }

void Hub::on_frame(std::shared_ptr<const Frame> frame) {
    frame_ = std::move(frame);
    if (!ready() || viewers_.empty()) return;
    const auto present = moment();
    for (const auto& viewer : viewers_) {
        viewer->outbox.show(present);
        viewer->flush();
    }
}

void Hub::on_state(const SessionState& state) {
    const bool was_ready = ready();
    state_ = state;
    if (!was_ready && ready())
        for (const auto& viewer : viewers_) greet(*viewer);
    broadcast_state();
}

void Hub::greet(Viewer& viewer) {
    viewer.push(hello_event(*model_, *state_));
    viewer.outbox.set_progress(nullptr);
    viewer.outbox.show(moment());
    viewer.flush();
}

void Hub::broadcast_state() {
    if (!ready() || viewers_.empty()) return;
    const SharedBytes bytes = share(state_event(*state_, viewers_.size()));
    for (const auto& viewer : viewers_) {
        viewer->outbox.set_state(bytes);
        viewer->flush();
    }
}

/// The present frame's messages, encoded when somebody wants them; the topology only when it has changed.
std::shared_ptr<const Moment> Hub::moment() {
    if (encoded_frame_ == frame_) return encoded_;
    constexpr std::uint16_t generation = 1;  // one model per process so far
    auto next = std::make_shared<Moment>();
    next->generation = generation;
    next->epoch = frame_->topology->epoch;
    next->model = encoded_ ? encoded_->model : share(encode_model(*frame_->model, generation));
    next->topology = encoded_ && encoded_frame_->topology == frame_->topology
                         ? encoded_->topology
                         : share(encode_topology(*frame_->topology, frame_->front_positions.size(), generation));
    next->frame = share(encode_frame(*frame_, generation, ++sequence_));
    encoded_ = std::move(next);
    encoded_frame_ = frame_;
    return encoded_;
}

}  // namespace tetfront
