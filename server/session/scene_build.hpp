#pragma once
// Reads a scene and builds its model on a thread of its own.
//
//     SceneBuild build([file] { return load_scene(file); }, 4'000'000, cache, progress, [] { wake_up(); });
//     if (build.finished()) model = build.take();         // or throws what building has thrown

#include "engine/scene/scene.hpp"
#include "engine/simulation/simulation.hpp"

#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <memory>
#include <thread>

namespace tetfront {

class SceneBuild {
 public:
    /// most_tets: a scene with more of the smallest tets is refused, before it takes memory. read, progress and done are called on
    /// the thread that builds; done last, when finished() has become true.
    SceneBuild(std::function<Scene()> read, std::size_t most_tets, CacheSettings cache, Progress progress, std::function<void()> done);
    /// Ends the build after the stage that it is in.
    ~SceneBuild();
    SceneBuild(const SceneBuild&) = delete;
    SceneBuild& operator=(const SceneBuild&) = delete;

    [[nodiscard]] bool finished() const { return finished_; }
    /// Once, when finished. Throws what building has thrown.
    std::shared_ptr<const Model> take();

 private:
    std::atomic<bool> stopping_ = false, finished_ = false;
    std::shared_ptr<const Model> model_;  // the thread's until finished_
    std::exception_ptr error_;            // the same
    std::thread thread_;
};

}  // namespace tetfront
