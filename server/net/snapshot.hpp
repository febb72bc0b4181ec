#pragma once
// Pictures of the present moment for other programs: GET /snapshot.png. Knows no sockets.
//
//     const SnapshotQuery query = parse_snapshot_query("w=640&h=360&camera=3,-4,2,0,0,0", scene.view);
//     SnapshotPainter painter;
//     painter.submit({frame, make_view(query.view, ...), "Bunny"}, [](SnapshotPainter::Result result) { ... });

#include "engine/scene/view_spec.hpp"
#include "engine/simulation/frame.hpp"
#include "server/render/view.hpp"

#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>

namespace tetfront {

struct SnapshotQuery {
    std::string view_text;  // the JSON of the key view; empty: it was not there
    int width = 1280, height = 720;  // [pixels] each 16..4096
    ViewSpec view;
};

/// What follows the question mark; each key at most once:
/// w, h; camera: six numbers, eye and target [m]; colouring; view: a JSON object as in a scene's `view`. Percent-encoded.
/// base: what is not said. Throws InputError.
SnapshotQuery parse_snapshot_query(std::string_view query, const ViewSpec& base);

/// Draws one picture at a time on a thread of its own, which starts with the first.
class SnapshotPainter {
 public:
    struct Work {
        std::shared_ptr<const Frame> frame;
        View view;
        std::string title;
    };
    struct Result {
        std::string png;      // empty when it failed
        std::string problem;  // one line
    };
    using Done = std::function<void(Result)>;

    SnapshotPainter() = default;
    ~SnapshotPainter();  // after the picture that is being drawn; others are not drawn
    SnapshotPainter(const SnapshotPainter&) = delete;
    SnapshotPainter& operator=(const SnapshotPainter&) = delete;

    /// Ends the thread after the picture that it draws. False: it still draws.
    bool stop_within(std::chrono::milliseconds patience);
    /// Calls `done` on the painter's thread. At most one picture waits: the caller asks for no more (see Hub).
    void submit(Work work, Done done);

 private:
    void run();

    std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<std::pair<Work, Done>> next_;
    bool stopping_ = false, ended_ = false;
    std::thread thread_;
};

}  // namespace tetfront
