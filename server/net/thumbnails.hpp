#pragma once
// Small pictures of the scenes that may be loaded, drawn by another process when they are first asked for, one at a time,
// and kept beside the recordings. Included by server.cpp only, see there; all of it belongs to the serving thread.
//
//     Thumbnails thumbnails(io.get_executor(), library);
//     thumbnails.get("bunny", [](const std::string& png) { ... });
//     thumbnails.stop();                        // who still waits is told
//
// A picture shows the object at rest on the coarsest level, which takes a second where the whole scene takes a minute. It is
// made anew when the scene's file is younger.

#include "engine/base/atomic_file.hpp"
#include "engine/base/error.hpp"
#include "engine/scene/json_document.hpp"
#include "server/base/exit_status.hpp"
#include "server/net/child_output.hpp"
#include "server/net/hub.hpp"
#include "server/session/library.hpp"

#include <array>
#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <boost/asio/steady_timer.hpp>
#include <spdlog/spdlog.h>

namespace tetfront {

class Thumbnails {
 public:
    Thumbnails(const boost::asio::any_io_executor& executor, const Library& library) : executor_(executor), deadline_(executor), library_(library) {}

    /// `done` is called once: at once when the picture is there or cannot be made, else later.
    void get(const std::string& name, Hub::ThumbnailDone done) {
        const auto scene = library_.scene_file(name);
        if (!scene || stopped_) return done("");
        std::error_code unknown;
        const auto made = std::filesystem::last_write_time(*scene, unknown);
        const auto known = known_.find(name);
        if (known != known_.end() && known->second.scene == made) return done(known->second.png);
        if (std::string png = kept(name, made); !png.empty()) return done((known_[name] = {made, std::move(png)}).png);
        const bool asked = !waiting_[name].empty();
        waiting_[name].push_back(std::move(done));
        if (!asked) queue_.push_back({name, *scene, made});
        draw_next();
    }

    void stop() {
        stopped_ = true;
        if (child_) child_->stop();
        deadline_.cancel();
        for (auto& [name, all] : std::exchange(waiting_, {}))
            for (const auto& done : all) done("");
        queue_.clear();
    }

 private:
    using Time = std::filesystem::file_time_type;
    struct Job {
        std::string name;
        std::filesystem::path scene;
        Time made;
    };
    struct Known {
        Time scene;
        std::string png;  // empty: it cannot be drawn
    };

    /// What an earlier server has drawn; empty: nothing, or the scene is younger.
    std::string kept(const std::string& name, Time scene) const {
        std::error_code error;
        if (!library_.keeps()) return "";
        const auto time = std::filesystem::last_write_time(library_.thumbnail(name), error);
        if (error || time < scene) return "";
        try {
            return read_text_file(library_.thumbnail(name));
        } catch (const InputError& problem) {
            spdlog::warn("{}", problem.what());  // and it is drawn again
            return "";
        }
    }

    void draw_next() {
        if (child_ || queue_.empty()) return;
        job_ = std::move(queue_.front());
        queue_.pop_front();
        try {
            child_ = std::make_unique<ChildOutput>(
                executor_, std::vector<std::string>{"render", job_.scene.string(), "--frames", "1", "--size", "320x200", "--stdout", "png", "--overlay",
                                                    "none", "--colour", "stiffness", "--set", "levels=0", "--set", "front/order=1", "--no-cache",
                                                    "--threads", "1", "--command", "tetfront render " + job_.name});
        } catch (const OutputError& error) {
            return finish({{}, error.what()});
        }
        deadline_.expires_after(longest);
        deadline_.async_wait([this](boost::system::error_code error) {
            // What was under way already when it was cancelled belongs to another picture than the present one.
            if (!error && child_ && deadline_.expiry() <= std::chrono::steady_clock::now()) child_->stop();
        });
        read();
    }
    void read() {
        child_->read(boost::asio::buffer(piece_), [this](boost::system::error_code error, std::size_t size) {
            if (!error && png_.size() < most_bytes) {
                png_.append(piece_.data(), size);
                return read();
            }
            if (error != boost::asio::error::eof) child_->stop();  // too large, or not to be read
            child_->wait([this](const ChildOutput::End& end) { finish(end); });
        });
    }
    /// end.problem: empty when png_ is whole.
    void finish(const ChildOutput::End& end) {
        child_.reset();
        deadline_.cancel();
        if (stopped_) return;
        if (!end.problem.empty()) {
            spdlog::warn("the scene {} has no picture in the list: {}", job_.name, end.problem);
            png_.clear();
        } else if (library_.keeps()) {
            try {
                write_atomically(library_.new_thumbnail(job_.name), png_, Durable::no);
            } catch (const OutputError& error) {
                spdlog::warn("{}", error.what());  // and it is drawn again after a restart
            }
        }
        const std::string made = std::exchange(png_, "");
        // A lack of memory or time may pass; what is wrong with the scene stays until its file is another.
        if (!made.empty() || end.how.status == exit_bad_input) known_[job_.name] = {job_.made, made};
        const auto node = waiting_.extract(job_.name);
        if (!node.empty())
            for (const auto& done : node.mapped()) done(made);
        draw_next();
    }

    static constexpr std::chrono::seconds longest{120};
    static constexpr std::size_t most_bytes = 4 << 20;

    boost::asio::any_io_executor executor_;
    boost::asio::steady_timer deadline_;
    const Library& library_;
    std::map<std::string, Known> known_;
    std::map<std::string, std::vector<Hub::ThumbnailDone>> waiting_;
    std::deque<Job> queue_;
    Job job_;  // that child_ draws
    std::unique_ptr<ChildOutput> child_;
    std::string png_;
    std::array<char, 64 * 1024> piece_{};
    bool stopped_ = false;
};

}  // namespace tetfront
