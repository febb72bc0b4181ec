#include "server/net/snapshot.hpp"

#include "engine/base/error.hpp"
#include "server/render/png.hpp"
#include "server/render/renderer.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <exception>
#include <set>
#include <utility>

namespace tetfront {

namespace {

constexpr int largest_side = 4096;

[[noreturn]] void fail(std::string_view key, const std::string& problem, const std::string& remedy) {
    throw InputError("snapshot", std::string(key.substr(0, 32)), problem, remedy);
}

std::string decoded(std::string_view key, std::string_view text) {
    const auto digit = [](char c) {
        return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
    };
    std::string plain;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            plain += text[i] == '+' ? ' ' : text[i];
            continue;
        }
        const bool whole = text.size() - i > 2;
        const int high = whole ? digit(text[i + 1]) : -1, low = whole ? digit(text[i + 2]) : -1;
        if (high < 0 || low < 0) fail(key, "is not percent-encoded", "write % as %25");
        plain += static_cast<char>(16 * high + low);
        i += 2;
    }
    return plain;
}

template <class Number>
Number number(std::string_view key, std::string_view text, Number low, Number high) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size() || !(value >= low && value <= high))
        fail(key, "is not a number in its range", "use " + std::to_string(low) + " to " + std::to_string(high));
    return value;
}

}  // namespace

SnapshotQuery parse_snapshot_query(std::string_view query, const ViewSpec& base) {
    SnapshotQuery result;
    result.view = base;
    result.view.keyframes.clear();
    std::set<std::string, std::less<>> seen;
    while (!query.empty()) {
        const std::string_view part = query.substr(0, query.find('&'));
        query.remove_prefix(std::min(query.size(), part.size() + 1));
        if (part.empty()) continue;
        const std::string_view key = part.substr(0, part.find('='));
        const std::string value = decoded(key, part.substr(std::min(part.size(), key.size() + 1)));
        if (!seen.emplace(key).second) fail(key, "is there twice", "say it once");
        if (key == "w") {
            result.width = number(key, value, 16, largest_side);
        } else if (key == "h") {
            result.height = number(key, value, 16, largest_side);
        } else if (key == "colouring") {
            result.view = parse_view("{\"colouring\": \"" + value + "\"}", "snapshot", result.view);
        } else if (key == "view") {
            result.view = parse_view(value, "snapshot", result.view);
            result.view.keyframes.clear();
            result.view_text = value;
        } else if (key == "camera") {
            std::array<double, 6> at{};
            std::string_view left = value;
            for (double& x : at) {
                const std::string_view word = left.substr(0, left.find(','));
                x = number(key, word, -1e6, 1e6);
                left.remove_prefix(std::min(left.size(), word.size() + 1));
            }
            if (!left.empty()) fail(key, "has more than six numbers", "use eye x,y,z and target x,y,z");
            result.view.eye = {at[0], at[1], at[2]}, result.view.target = {at[3], at[4], at[5]};
            result.view.fitted = false;
            if ((result.view.eye - result.view.target).norm() < 1e-6)
                fail(key, "looks from where it looks at", "use two different points");
        } else {
            fail(key, "is not a key of this address", "use w, h, camera, colouring, view");
        }
    }
    return result;
}

bool SnapshotPainter::stop_within(std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    stopping_ = true;
    changed_.notify_all();
    return !thread_.joinable() || changed_.wait_for(lock, patience, [this] { return ended_; });
}

SnapshotPainter::~SnapshotPainter() {
    {
        const std::lock_guard lock(mutex_);
        stopping_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
}

void SnapshotPainter::submit(Work work, Done done) {
    {
        const std::lock_guard lock(mutex_);
        ENSURE(!next_, "a picture waits already");
        next_.emplace(std::move(work), std::move(done));
        if (!thread_.joinable()) thread_ = std::thread([this] { run(); });
    }
    changed_.notify_all();
}

void SnapshotPainter::run() {
    std::unique_ptr<Renderer> renderer;  // its GL context belongs to this thread
    for (;;) {
        std::optional<std::pair<Work, Done>> next;
        {
            std::unique_lock lock(mutex_);
            changed_.wait(lock, [this] { return stopping_ || next_; });
            if (stopping_) {
                ended_ = true;
                changed_.notify_all();
                return;
            }
            next.swap(next_);
        }
        Result result;
        try {
            if (!renderer) renderer = std::make_unique<Renderer>();
            const auto& [work, done] = *next;
            result.png = encode_png(renderer->render(*work.frame, work.view, work.title),
                                    {.level = 1, .text = {{"Software", std::string("tetfront ") + TETFRONT_VERSION},
                                                          {"View", view_json(work.view)},
                                                          {"Time", std::to_string(work.frame->status.time)}}});
        } catch (const std::exception& error) {
            result.problem = error.what();
        }
        next->second(std::move(result));
    }
}

}  // namespace tetfront
