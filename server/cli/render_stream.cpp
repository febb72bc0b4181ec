#include "server/cli/render_stream.hpp"

#include "engine/base/error.hpp"
#include "server/cli/video.hpp"
#include "server/render/zip.hpp"

#include <csignal>
#include <cstdio>
#include <memory>
#include <system_error>

#include <unistd.h>

namespace tetfront {

void check_stream(const RenderOptions& options) {
    const auto refuse = [](const char* option) {
        throw InputError(option, "", "belongs to a directory of pictures", "leave it out, or leave out --stdout");
    };
    if (options.resume) refuse("--resume");
    if (options.jobs > 1) refuse("--jobs");
    if (options.json) refuse("--json");
    if (!options.video.empty()) refuse("--video");
    if (::isatty(STDOUT_FILENO) == 1)
        throw InputError("--stdout", options.stream, "is nothing for a terminal", "send it to a file: > frames." + options.stream);
}

int render_to_stdout(Work& work, const std::string& format, int threads) {
    const int count = work.numbers.last - work.numbers.first + 1;
    if (format == "zip" && count > static_cast<int>(ZipWriter::most_files))
        throw InputError("--stdout", "zip", "holds 65,535 files, and these are " + std::to_string(count) + " pictures",
                         "take a part of them with --frames, or fewer with --every");
    std::signal(SIGPIPE, SIG_IGN);  // a reader that has gone is an error of writing, which says so
    const View& view = work.sequence.view;
    const auto to_stdout = [](std::string_view bytes) {
        if (const int error = write_all(STDOUT_FILENO, bytes))
            throw OutputError("standard output cannot be written: " + std::generic_category().message(error));
    };
    std::unique_ptr<ZipWriter> zip;
    std::unique_ptr<VideoStream> video;
    if (format == "zip")
        zip = std::make_unique<ZipWriter>(to_stdout);
    else if (format == "mp4")
        video = std::make_unique<VideoStream>(work.fps, view.width % 2 == 0 && view.height % 2 == 0, threads);
    work.sequence.write = [&](const std::string& name, std::string_view png) {
        if (zip)
            zip->add(name, png);
        else
            video ? video->add(png) : to_stdout(png);
    };
    for (int i = work.numbers.first; i <= work.numbers.last; ++i) work.sequence.numbers.push_back(i);
    FrameProgress progress(count, ::isatty(STDERR_FILENO) == 0);
    const SequenceReport report = render_sequence(work.sequence, work.source, [&](int written) {
        progress.show(written);
        return !work.interrupted();
    });
    work.complain();
    if (report.written < count) {
        std::fprintf(stderr, "tetfront: stopped after %d of %d frames\n", report.written, count);
        return exit_interrupted;
    }
    if (zip) zip->finish();
    if (video) video->finish();
    return exit_ok;
}

}  // namespace tetfront
