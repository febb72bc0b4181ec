#pragma once
// Who is connected, and what everybody is shown. Belongs to the serving thread; knows no sockets.
//
//     hub.on_frame(frame);     // encoded once, put into every viewer's outbox
//     hub.add(viewer);         // greeted with hello, model, topology, frame and state as soon as there are any

#include "server/net/access.hpp"
#include "server/net/limits.hpp"
#include "server/net/metrics.hpp"
#include "server/net/outbox.hpp"
#include "server/net/protocol.hpp"
#include "server/net/snapshot.hpp"
#include "server/net/web_files.hpp"
#include "server/session/remaining_time.hpp"
#include "server/session/session.hpp"

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

namespace tetfront {

/// Anything that has to end before the server can.
struct Connection {
    std::string address;  // of the other side
    virtual ~Connection() = default;
    virtual void shut_down() = 0;  // ends soon, and then calls Hub::remove
};

/// A connection that is shown the simulation.
struct Viewer : Connection {
    Outbox outbox;
    Outbox::Clock::time_point last_link{};    // when it was told about its link
    std::uint64_t link_sent = 0;              // frames sent by then
    virtual void flush() = 0;                 // after a change of the outbox; sends when nothing is being sent
    virtual void push(std::string text) = 0;  // outbox.push; a viewer whose outbox is full is closed
};

class Hub {
 public:
    Hub(Session& session, WebFiles files, AccessPolicy access, Limits limits);

    Session& session;
    const WebFiles files;
    const AccessPolicy access;
    const Limits limits;
    Metrics metrics;
    static constexpr int most_exports = 2;
    int exports = 0;                           // recordings that are being drawn for a download
    /// Set by the server: draws a small picture of a scene. The PNG's bytes are empty when it cannot be drawn.
    using ThumbnailDone = std::function<void(const std::string& png)>;
    std::function<void(const std::string& scene, ThumbnailDone)> thumbnail;

    [[nodiscard]] std::size_t connection_count() const { return connections_.size(); }
    [[nodiscard]] std::size_t viewer_count() const { return viewers_.size(); }
    /// Of one address, this kind of connection and the other.
    [[nodiscard]] std::size_t connections_of(const std::string& address) const;
    void add(const std::shared_ptr<Connection>& connection);
    void remove(const std::shared_ptr<Connection>& connection);
    void add_viewer(const std::shared_ptr<Viewer>& viewer);
    void remove_viewer(const std::shared_ptr<Viewer>& viewer);
    ClientId new_client() { return ++last_client_; }
    /// After a viewer's field has changed.
    void show_fields();

    /// Everything that Prometheus is told.
    [[nodiscard]] std::string metrics_page() const;
    /// Empty: the simulation thread is well; otherwise one line.
    [[nodiscard]] std::string stalled() const;
    /// A viewer would see frames.
    [[nodiscard]] bool ready() const { return model_ && frame_ && state_; }

    /// A picture of the present moment; `done` is called once, on any thread, unless this returns a refusal.
    enum class Refusal { none, not_ready, busy };
    Refusal snapshot(const SnapshotQuery& query, SnapshotPainter::Done done);
    /// No more pictures; false: one is still being drawn after so long.
    bool end_pictures(std::chrono::milliseconds patience) { return painter_.stop_within(patience); }
    [[nodiscard]] const SessionModel* model() const { return model_.get(); }

    /// Ends all connections, and calls `done` when none is left.
    void shut_down(std::function<void()> done);
    [[nodiscard]] bool shutting_down() const { return done_ != nullptr; }

    // Events of the session.
    void on_progress(const std::string& what, double fraction);
    void on_model(std::shared_ptr<const SessionModel> model);
    void on_frame(const Shots& shots);
    void on_state(const SessionState& state);

 private:
    void greet(Viewer& viewer);
    void broadcast_state();
    void broadcast(const std::string& text);
    void set_all(Outbox::Slot slot, const SharedBytes& text);
    std::shared_ptr<const Moment> moment();
    std::function<SharedBytes(FrameKind)> frame_encoder();

    std::set<std::shared_ptr<Connection>> connections_;
    std::set<std::shared_ptr<Viewer>> viewers_;
    ClientId last_client_ = 0;
    std::function<void()> done_;

    std::shared_ptr<const SessionModel> model_;
    std::uint16_t generation_ = 0;  // of model_
    std::shared_ptr<const Frame> frame_;
    std::vector<std::shared_ptr<const Frame>> coloured_;  // the same moment
    Shots early_;  // came before its model: the slot for frames overtakes
    std::optional<SessionState> state_;
    SharedBytes progress_, settings_, recording_;
    bool recording_active_ = false;  // as viewers were told; a scene that is loaded ends a recording
    std::chrono::steady_clock::time_point last_recording_{};
    std::map<std::string, std::size_t> addresses_;  // connections
    std::set<Field> fields_;                        // that viewers want
    std::shared_ptr<std::atomic<bool>> painting_ = std::make_shared<std::atomic<bool>>(false);
    std::chrono::steady_clock::time_point last_snapshot_{};
    RemainingTime remaining_;
    std::string stage_;

    std::shared_ptr<const Moment> encoded_;  // of encoded_frame_
    std::shared_ptr<const Frame> encoded_frame_;
    std::uint32_t sequence_ = 0;
    SnapshotPainter painter_;  // last: its thread ends before the rest goes
};

}  // namespace tetfront
