#pragma once
// All pictures of a sequence down one pipe: for `tetfront render --stdout`, which the server starts when somebody
// downloads a recording as pictures or as a video. Whoever reads may stop at any time.
//
//     check_stream(options);                        // before the long work
//     return render_to_stdout(prepare(options), "zip");

#include "server/cli/render_work.hpp"

#include <string>

namespace tetfront {

/// Throws InputError for options that only a directory has.
void check_stream(const RenderOptions& options);

/// format: "zip", "png" (one after the other) or "mp4". threads: of ffmpeg, 0: as it likes. Returns an exit status. Throws
/// OutputError, also when there is no ffmpeg for a video; InputError for more pictures than a zip file holds.
int render_to_stdout(Work& work, const std::string& format, int threads);

}  // namespace tetfront
