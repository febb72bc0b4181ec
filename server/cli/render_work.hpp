#pragma once
// What `tetfront render` is asked for, and what that means for a scene or a recording: which frames, from where, seen how.
//
//     const Work work = prepare(options);       // after this nothing is wrong with the input
//     render_sequence(work.sequence, work.source, ...);

#include "server/cli/commands.hpp"
#include "server/cli/frame_work.hpp"
#include "server/render/sequence.hpp"

#include <functional>
#include <string>
#include <vector>

namespace tetfront {

struct RenderOptions {
    SceneArguments scene;
    std::string frames, view, colour, command;
    double seconds = 0, fps = 0, start_at = 0;  // fps 0: 30, or the recording's
    int every = 1, jobs = 1, threads = 0;  // threads 0: as many as there are processors
    std::string size = "1280x720", directory = "frames", camera = "fixed", background, range, video, stream;
    std::vector<std::string> overlay;
    bool wireframe = false, no_surface = false, no_legend = false, resume = false, json = false;
    int supersampling = 2, png_level = 1;
};

/// Where frames come from, and what is the same for all of them.
struct Work {
    SequenceOptions sequence;
    FrameNumbers numbers;
    double fps = 30;
    FrameSource source;
    std::function<bool()> interrupted;
    std::function<void()> complain;
};

/// Reads and checks everything, and builds the model of a scene. Throws InputError; OutputError when the directory cannot
/// be written.
Work prepare(const RenderOptions& options);

}  // namespace tetfront
