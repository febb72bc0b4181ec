// Many viewers at once: what they cost the simulation, how old their frames are, whether memory stays flat, how long a
// cursor's move takes to show, how soon SIGTERM ends it, and what one viewer notices of another's download. Starts `tetfront serve` as a process of its own, for one viewer, for many
// and for as many as are the goal; writes tests/reports/server.md.
//
//     build/release/tests/load_report [--viewers 64] [--minutes 10] [--goal 200] [--cycles 10000] [REPORT]   (on an idle machine)
//
// Some 13 minutes as it is. Age: from the sending of a frame to its acknowledgement, as the server measures it for each client
// (event `link`), so an upper bound of the age at the client.

#include <algorithm>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/http.hpp>

#include "tests/support/project.hpp"
#include "tests/support/report.hpp"
#include "tests/support/server_process.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/watching_client.hpp"

using namespace std::chrono_literals;
using namespace tetfront;
using namespace tetfront::testing;

namespace {

double quantile(std::vector<double> values, double q) {
    if (values.empty()) return 0;
    std::ranges::sort(values);
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

/// [MB/min] of a straight line through samples of one second.
double slope_of(const std::vector<double>& samples) {
    const auto n = static_cast<double>(samples.size());
    double mean = 0, above = 0, below = 0;
    for (double s : samples) mean += s / n;
    for (std::size_t i = 0; i < samples.size(); ++i) {
        const double t = static_cast<double>(i) - (n - 1) / 2;
        above += t * (samples[i] - mean), below += t * t;
    }
    return below > 0 ? 60 * above / below : 0;
}

/// data: where it keeps recordings; empty: nowhere.
ServerProcess serve_the_bunny(const std::string& data = "") {
    return ServerProcess({(source_folder() / "assets/scenes/bunny.json").string(), "--max-connections", "1000", "--max-clients", "1000",
                          "--max-per-address", "1000", "--data", data});
}

struct Result {
    int viewers = 0;
    double rate = 0, frames_a_second = 0, slowest_frames_a_second = 0, megabytes_a_second = 0;  // the last three of one viewer
    std::vector<double> ages, latencies;
    double memory = 0, slope = 0;  // [MB], [MB/min] over the second half
    std::uint64_t dropped = 0, backwards = 0, lost = 0;
    double end = 0;  // [s] from SIGTERM to the end of the process
};

Result watch(int count, double seconds) {
    ServerProcess server = serve_the_bunny();
    asio::io_context io;
    std::vector<std::shared_ptr<WatchingClient>> viewers;
    for (int i = 0; i < count; ++i) {
        viewers.push_back(std::make_shared<WatchingClient>(io, server.port()));
        viewers.back()->read();
        io.poll();
    }
    while (viewers.front()->frames == 0) io.run_one_for(1s);
    viewers.front()->drag();
    const auto start = Clock::now();
    std::vector<double> memory;
    std::vector<std::uint64_t> frames_before, bytes_before;
    for (const auto& v : viewers) frames_before.push_back(v->frames), bytes_before.push_back(v->bytes);
    while (seconds_since(start) < seconds) {
        io.run_for(1s);
        memory.push_back(server.resident_megabytes());
    }
    const double elapsed = seconds_since(start);
    Result r;
    r.viewers = count;
    std::vector<double> frames;
    for (std::size_t i = 0; i < viewers.size(); ++i) {
        const WatchingClient& v = *viewers[i];
        frames.push_back(static_cast<double>(v.frames - frames_before[i]) / elapsed);
        r.megabytes_a_second += static_cast<double>(v.bytes - bytes_before[i]) / 1e6 / elapsed / count;
        r.ages.insert(r.ages.end(), v.ages.begin(), v.ages.end());
        r.dropped += v.dropped, r.backwards += v.backwards, r.lost += v.lost ? 1 : 0;
    }
    r.frames_a_second = quantile(frames, 0.5);
    r.slowest_frames_a_second = quantile(frames, 0);
    r.latencies = viewers.front()->latencies;
    r.rate = quantile(viewers.front()->rates, 0.5);
    r.memory = memory.back();
    r.slope = slope_of({memory.begin() + static_cast<std::ptrdiff_t>(memory.size() / 2), memory.end()});

    const auto told = Clock::now();  // everybody still watches
    server.signal(SIGTERM);
    while (std::ranges::any_of(viewers, [](const auto& v) { return !v->lost; }) && seconds_since(told) < 30) io.run_one_for(100ms);
    const int status = server.wait().status;
    r.end = seconds_since(told);
    if (status != 0) throw std::runtime_error("the server ended with status " + std::to_string(status));
    return r;
}

struct Churn {
    int cycles = 0;
    double memory_before = 0, memory_after = 0;  // [MB]
    long descriptors_before = 0, descriptors_after = 0, threads_before = 0, threads_after = 0;
};

/// Connects and leaves, every other time in the middle of a message.
Churn churn(int cycles) {
    ServerProcess server = serve_the_bunny();
    asio::io_context io;
    const auto viewer = std::make_shared<WatchingClient>(io, server.port());
    viewer->read();
    while (viewer->frames == 0) io.run_one_for(1s);
    Churn result{.cycles = cycles};
    const auto cycle = [&](int i) {
        tcp::socket socket(io);
        socket.connect({asio::ip::make_address("127.0.0.1"), server.port()});
        asio::write(socket, asio::buffer("GET /ws HTTP/1.1\r\nHost: " + server.host() +
                                         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                                         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: tetfront.v1\r\n\r\n"));
        char begin[64];
        Error ended;
        socket.read_some(asio::buffer(begin), ended);
        if (i % 2) asio::write(socket, asio::buffer(std::string("\x81\xfe\x10\x00half", 8)), ended);
        io.poll();
    };
    io.run_for(10s);  // the simulation's own memory grows until its front has settled, whoever connects
    for (int i = 0; i < cycles / 10; ++i) cycle(i);  // caches and pools fill
    result.memory_before = server.resident_megabytes(), result.descriptors_before = server.descriptors(), result.threads_before = server.threads();
    for (int i = 0; i < cycles; ++i) cycle(i);
    io.run_for(3s);
    result.memory_after = server.resident_megabytes(), result.descriptors_after = server.descriptors(), result.threads_after = server.threads();
    if (viewer->lost) throw std::runtime_error("the viewer that stayed lost its connection");
    return result;
}

struct Asleep {
    int viewers = 0;
    double seconds = 0, memory_before = 0, memory_after = 0;  // [s], [MB]
    std::uint64_t frames = 0;                                 // the most that one of them got
};

/// Viewers that do not show anything any more while another one watches.
Asleep sleep(int count, double seconds) {
    ServerProcess server = serve_the_bunny();
    asio::io_context io;
    const auto awake = std::make_shared<WatchingClient>(io, server.port());
    awake->read();
    while (awake->frames == 0) io.run_one_for(1s);
    std::vector<std::shared_ptr<WatchingClient>> viewers;
    for (int i = 0; i < count; ++i) {
        viewers.push_back(std::make_shared<WatchingClient>(io, server.port()));
        viewers.back()->read();
        io.poll();
    }
    io.run_for(10s);  // until the front has settled
    Asleep result{.viewers = count, .seconds = seconds};
    std::vector<std::uint64_t> before;
    for (const auto& v : viewers) v->asleep = true, before.push_back(v->frames);
    result.memory_before = server.resident_megabytes();
    io.run_for(std::chrono::milliseconds(static_cast<int>(1000 * seconds)));
    result.memory_after = server.resident_megabytes();
    for (std::size_t i = 0; i < viewers.size(); ++i) result.frames = std::max(result.frames, viewers[i]->frames - before[i]);
    if (awake->lost) throw std::runtime_error("the viewer that watched lost its connection");
    return result;
}

struct Download {
    double pictures = 0, seconds = 0, megabytes = 0;
    double rate_before = 0, rate_meanwhile = 0;                    // [steps/s]
    std::vector<double> latencies_before, latencies_meanwhile;  // [s]
};

/// What a viewer that drags notices while a recording is drawn and sent to somebody else.
Download download(double seconds_recorded) {
    const TemporaryFolder data;
    ServerProcess server = serve_the_bunny(data.path().string());
    asio::io_context io;
    const auto viewer = std::make_shared<WatchingClient>(io, server.port());
    viewer->read();
    while (viewer->frames == 0) io.run_one_for(1s);
    viewer->drag();
    const auto watch_for = [&](double seconds) { io.run_for(std::chrono::milliseconds(static_cast<int>(1000 * seconds))); };
    viewer->send(R"({"id":1000000,"command":"record_start","name":"run"})");
    watch_for(seconds_recorded);
    viewer->send(R"({"id":1000001,"command":"record_stop"})");
    watch_for(2);
    const auto forget = [&] { viewer->rates.clear(), viewer->latencies.clear(); };
    Download result;
    forget();
    watch_for(seconds_recorded);
    result.rate_before = quantile(viewer->rates, 0.5);
    result.latencies_before = viewer->latencies;
    forget();

    beast::tcp_stream stream(io);
    stream.connect({asio::ip::make_address("127.0.0.1"), server.port()});
    beast::http::request<beast::http::empty_body> request(beast::http::verb::get, "/recordings/run.tfr/frames.zip?w=1280&h=720", 11);
    request.set(beast::http::field::host, server.host());
    beast::http::write(stream, request);
    beast::http::response_parser<beast::http::string_body> answer;
    answer.body_limit(std::uint64_t{4} << 30);
    beast::flat_buffer buffer;
    bool done = false;
    Error failed;
    const auto start = Clock::now();
    beast::http::async_read(stream, buffer, answer, [&](Error error, std::size_t) { failed = error, done = true; });
    while (!done) io.run_one_for(1s);
    result.seconds = seconds_since(start);
    const std::string& zip = answer.get().body();
    if (failed || answer.get().result_int() != 200) throw std::runtime_error("the download failed: " + failed.message() + " " + zip.substr(0, 200));
    if (viewer->lost) throw std::runtime_error("the viewer lost its connection");
    result.megabytes = static_cast<double>(zip.size()) / 1e6;
    const std::size_t end = zip.rfind("PK\5\6");  // the end record; entries in all, 16 bits, ten bytes on
    if (end == std::string::npos || end + 22 > zip.size()) throw std::runtime_error("the download is no zip file");
    result.pictures = static_cast<unsigned char>(zip[end + 10]) + 256 * static_cast<unsigned char>(zip[end + 11]);
    result.rate_meanwhile = quantile(viewer->rates, 0.5);
    result.latencies_meanwhile = viewer->latencies;
    return result;
}

/// A row: what, one cell of each result, what is wanted.
void row(std::ostream& out, const char* what, const std::vector<Result>& results, const std::function<std::string(const Result&)>& cell,
         const char* wanted) {
    out << "| " << what << " |";
    for (const Result& r : results) out << ' ' << cell(r) << " |";
    out << ' ' << wanted << " |\n";
}

std::string p50_and_p99(const std::vector<double>& seconds) {
    return number(1000 * quantile(seconds, 0.5)) + " / " + number(1000 * quantile(seconds, 0.99));
}

void write_report(std::ostream& out, const std::vector<Result>& results, double minutes, const Churn& left, const Asleep& asleep,
                  const Download& drawn) {
    const double alone = results.front().rate;
    out << "\nThe bunny, dragged by the first viewer; server and viewers on one machine, which therefore also reads and decodes what it sends. "
        << number(minutes) << " minutes with " << results[1].viewers
        << " viewers, less with the others. Age: from the sending of a frame to its acknowledgement, once a second of each viewer. Cursor to "
           "frame: from the sending of a move to the first frame that a step has made with it.\n\n|";
    for (const Result& r : results) out << " | " << r.viewers << (r.viewers == 1 ? " viewer" : " viewers");
    out << " | wanted |\n|---|";
    for (std::size_t i = 0; i < results.size(); ++i) out << "---|";
    out << "---|\n";
    row(out, "steps a second, median", results,
        [&](const Result& r) { return number(r.rate) + " (" + number(100 * r.rate / alone) + " %)"; }, "at least 90 % of one viewer's");
    row(out, "frames a second of a viewer, median, slowest", results,
        [](const Result& r) { return number(r.frames_a_second) + ", " + number(r.slowest_frames_a_second); }, "30");
    row(out, "MB/s of a viewer", results, [](const Result& r) { return number(r.megabytes_a_second); }, "");
    row(out, "age of frames, p50 / p99 [ms]", results, [](const Result& r) { return p50_and_p99(r.ages); }, "");
    row(out, "cursor to frame, p50 / p99 [ms]", results, [](const Result& r) { return p50_and_p99(r.latencies); }, "35 / 70 with one viewer");
    row(out, "resident memory at the end [MB]", results, [](const Result& r) { return number(r.memory, "%.1f"); }, "");
    row(out, "its slope, second half [MB/min]", results, [](const Result& r) { return number(r.slope); }, "0");
    row(out, "frames replaced by newer ones", results, [](const Result& r) { return std::to_string(r.dropped); }, "");
    row(out, "frames out of order, connections lost", results,
        [](const Result& r) { return std::to_string(r.backwards) + ", " + std::to_string(r.lost); }, "0, 0");
    row(out, "from SIGTERM to the end [s]", results, [](const Result& r) { return number(r.end); }, "2");
    out << '\n' << left.cycles << " times connected and left, every other time in the middle of a message: resident memory "
        << number(left.memory_before, "%.1f") << " -> " << number(left.memory_after, "%.1f") << " MB, descriptors " << left.descriptors_before
        << " -> " << left.descriptors_after << ", threads " << left.threads_before << " -> " << left.threads_after << ".\n";
    out << '\n' << asleep.viewers << " viewers whose tabs are frozen, beside one that watches: each got " << asleep.frames << " frames at most in "
        << number(asleep.seconds) << " s, resident memory " << number(asleep.memory_before, "%.1f") << " -> " << number(asleep.memory_after, "%.1f")
        << " MB.\n";
    out << "\nWhile somebody else downloads " << number(drawn.pictures) << " pictures of 1280x720 (" << number(drawn.megabytes) << " MB in "
        << number(drawn.seconds) << " s), one viewer has " << number(drawn.rate_meanwhile) << " steps a second instead of " << number(drawn.rate_before)
        << ", and from cursor to frame p50 / p99 of " << p50_and_p99(drawn.latencies_meanwhile) << " ms instead of "
        << p50_and_p99(drawn.latencies_before) << " ms.\n";
}

}  // namespace

int main(int argc, char** argv) {
    int viewers = 64, goal = 200, cycles = 10'000;
    double minutes = 10;
    std::string report = (source_folder() / "tests/reports/server.md").string();
    CLI::App app("Measures a server under load");
    app.add_option("--viewers", viewers)->check(CLI::Range(2, 900));
    app.add_option("--minutes", minutes)->check(CLI::Range(0.05, 600.0));
    app.add_option("--goal", goal, "Viewers that we would like")->check(CLI::Range(2, 900));
    app.add_option("--cycles", cycles)->check(CLI::Range(10, 1'000'000));
    app.add_option("report", report);
    CLI11_PARSE(app, argc, argv);

    const double shorter = std::min(30.0, 60 * minutes);  // [s]
    std::vector<Result> results;
    results.push_back(watch(1, shorter));
    results.push_back(watch(viewers, 60 * minutes));
    results.push_back(watch(goal, shorter));
    const Churn left = churn(cycles);
    const Asleep asleep = sleep(viewers, shorter);
    const Download drawn = download(std::min(5.0, 60 * minutes));

    std::string command = "build/release/tests/load_report";
    for (int i = 1; i < argc; ++i) command += std::string(" ") + argv[i];
    std::ofstream out(report);
    write_head(out, "Many viewers at once", command);
    write_report(out, results, minutes, left, asleep, drawn);
    out.flush();
    if (!out) {
        std::cerr << report << " cannot be written\n";
        return 4;
    }
    std::cout << "wrote " << report << '\n';
    return 0;
}
