// Many viewers at once: what they cost the simulation, how old their frames are, whether memory stays flat, and how long a
// cursor's move takes to show. Starts `tetfront serve` as a process of its own, first for one viewer, then for many; writes
// tests/reports/server.md.
//
//     build/release/tests/load_report [--viewers 64] [--minutes 10] [--cycles 10000] [REPORT]     (on an idle machine)
//
// Age: from the sending of a frame to its acknowledgement, as the server measures it for each client (event `link`), so an
// upper bound of the age at the client. Cursor to frame: from a pull_move to the first frame that holds its target.

#include <algorithm>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/project.hpp"
#include "tests/support/report.hpp"

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace websocket = beast::websocket;
using asio::ip::tcp;
using Error = boost::system::error_code;
using Json = nlohmann::json;
using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;
using namespace tetfront::testing;

namespace {

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

double quantile(std::vector<double> values, double q) {
    if (values.empty()) return 0;
    std::ranges::sort(values);
    return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

/// `tetfront serve` on a free port; ends with this object.
class ServerProcess {
 public:
    ServerProcess(const std::string& program, const std::string& scene) {
        int out[2];
        if (pipe(out) != 0) throw std::runtime_error("no pipe");
        pid_ = fork();
        if (pid_ == 0) {
            dup2(out[1], STDOUT_FILENO);
            close(out[0]), close(out[1]);
            execl(program.c_str(), program.c_str(), "serve", scene.c_str(), "--port", "0", "--max-connections", "1000", "--max-clients", "1000",
                  "--max-per-address", "1000", "--log-level", "error", static_cast<char*>(nullptr));
            _exit(127);
        }
        close(out[1]);
        std::string url;
        for (char c = 0; read(out[0], &c, 1) == 1 && c != '\n';) url += c;
        close(out[0]);
        const std::size_t colon = url.rfind(':');
        if (colon == std::string::npos || url.size() < colon + 3) throw std::runtime_error(program + " serve did not start");
        port = static_cast<unsigned short>(std::stoi(url.substr(colon + 1)));
    }
    ~ServerProcess() {
        kill(pid_, SIGTERM);
        waitpid(pid_, nullptr, 0);
    }
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    [[nodiscard]] double resident_megabytes() const {
        std::ifstream statm("/proc/" + std::to_string(pid_) + "/statm");
        double all = 0, resident = 0;
        statm >> all >> resident;
        return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
    }
    [[nodiscard]] long descriptors() const {
        const std::filesystem::directory_iterator files("/proc/" + std::to_string(pid_) + "/fd");
        return std::distance(begin(files), end(files));
    }
    unsigned short port = 0;

 private:
    pid_t pid_ = -1;
};

/// A viewer that acknowledges every frame.
class Viewer : public std::enable_shared_from_this<Viewer> {
 public:
    Viewer(asio::io_context& io, unsigned short port) : stream_(io) {
        const std::string host = "127.0.0.1:" + std::to_string(port);
        stream_.next_layer().connect({asio::ip::make_address("127.0.0.1"), port});
        stream_.set_option(websocket::stream_base::decorator(
            [](websocket::request_type& request) { request.set(beast::http::field::sec_websocket_protocol, "tetfront.v1"); }));
        stream_.read_message_max(std::size_t{256} << 20);
        stream_.handshake(host, "/ws");
    }
    void read() {
        stream_.async_read(buffer_, [self = shared_from_this()](Error error, std::size_t size) {
            if (error) {
                ++self->lost;
                return;
            }
            self->bytes += size;
            self->on_message();
            self->buffer_.clear();
            self->read();
        });
    }
    void send(std::string text) {
        if (waiting_.size() < 1000) waiting_.push_back(std::move(text));
        write();
    }
    /// Grabs the first triangle and moves the cursor: each time that a frame shows the last move.
    void drag() {
        dragging_ = true;
        send(R"({"id":1,"command":"pull_begin","pull":0,"triangle":0,"barycentric":[1,0,0],"target":[0,0,0]})");
        move();
    }

    std::uint64_t frames = 0, bytes = 0, backwards = 0, lost = 0, dropped = 0;
    std::vector<double> ages, latencies, rates;  // [s], [s], [1/s]

 private:
    void move() {
        target_ = 0.01F * static_cast<float>(++moves_ % 10 + 1);
        moved_ = Clock::now();
        send(Json({{"id", 1 + moves_}, {"command", "pull_move"}, {"pull", 0}, {"target", {target_, target_, target_}}}).dump());
    }
    template <class T>
    T at(std::size_t offset) const {
        T value;
        std::memcpy(&value, static_cast<const char*>(buffer_.data().data()) + offset, sizeof value);
        return value;
    }
    void on_message() {
        if (stream_.got_text()) {
            const Json message = Json::parse(beast::buffers_to_string(buffer_.data()));
            if (message["type"] == "link") {
                dropped = message["dropped"];
                if (message["round_trip"].is_number()) ages.push_back(message["round_trip"]);
            } else if (message["type"] == "state" && message["steps_per_second"] > 0) {
                rates.push_back(message["steps_per_second"]);
            }
            return;
        }
        if (at<std::uint8_t>(0) != 3) return;
        ++frames;
        const auto sequence = at<std::uint32_t>(8);
        if (sequence <= last_sequence_) ++backwards;
        last_sequence_ = sequence;
        send("{\"command\":\"ack\",\"frame\":" + std::to_string(sequence) + "}");
        if (!dragging_ || at<std::uint32_t>(28) == 0) return;
        const std::size_t pulls = buffer_.size() - 28 * at<std::uint32_t>(28);
        if (at<float>(pulls + 12) != target_) return;
        latencies.push_back(seconds_since(moved_));
        move();
    }
    void write() {
        if (writing_ || waiting_.empty()) return;
        writing_ = true;
        const auto text = std::make_shared<std::string>(std::move(waiting_.front()));
        waiting_.erase(waiting_.begin());
        stream_.text(true);
        stream_.async_write(asio::buffer(*text), [self = shared_from_this(), text](Error error, std::size_t) {
            self->writing_ = false;
            if (!error) self->write();
        });
    }

    websocket::stream<tcp::socket> stream_;
    beast::flat_buffer buffer_;
    std::vector<std::string> waiting_;
    bool writing_ = false, dragging_ = false;
    std::uint32_t last_sequence_ = 0;
    int moves_ = 0;
    float target_ = -1;
    Clock::time_point moved_;
};

struct Result {
    int viewers = 0;
    double rate = 0, frames_a_second = 0, megabytes_a_second = 0;  // the last two of one viewer
    std::vector<double> ages, latencies;
    double memory = 0, slope = 0;  // [MB], [MB/min] over the second half
    std::uint64_t dropped = 0, backwards = 0, lost = 0;
};

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

Result watch(const std::string& program, const std::string& scene, int count, double seconds) {
    ServerProcess server(program, scene);
    asio::io_context io;
    std::vector<std::shared_ptr<Viewer>> viewers;
    for (int i = 0; i < count; ++i) {
        viewers.push_back(std::make_shared<Viewer>(io, server.port));
        viewers.back()->read();
        io.poll();
    }
    while (viewers.front()->frames == 0) io.run_one_for(1s);
    viewers.front()->drag();
    const auto start = Clock::now();
    std::vector<double> memory;
    std::uint64_t before = 0, bytes_before = 0;
    for (const auto& v : viewers) before += v->frames, bytes_before += v->bytes;
    while (seconds_since(start) < seconds) {
        io.run_for(1s);
        memory.push_back(server.resident_megabytes());
    }
    Result r{.viewers = count};
    for (const auto& v : viewers) {
        r.frames_a_second += static_cast<double>(v->frames), r.megabytes_a_second += static_cast<double>(v->bytes) / 1e6;
        r.ages.insert(r.ages.end(), v->ages.begin(), v->ages.end());
        r.dropped += v->dropped, r.backwards += v->backwards, r.lost += v->lost;
    }
    r.frames_a_second = (r.frames_a_second - static_cast<double>(before)) / seconds / count;
    r.megabytes_a_second = (r.megabytes_a_second - static_cast<double>(bytes_before) / 1e6) / seconds / count;
    r.latencies = viewers.front()->latencies;
    r.rate = quantile(viewers.front()->rates, 0.5);
    r.memory = memory.back();
    r.slope = slope_of({memory.begin() + static_cast<std::ptrdiff_t>(memory.size() / 2), memory.end()});
    return r;
}

struct Churn {
    int cycles = 0;
    double memory_before = 0, memory_after = 0;  // [MB]
    long descriptors_before = 0, descriptors_after = 0;
};

/// Connects and leaves, every other time in the middle of a message.
Churn churn(const std::string& program, const std::string& scene, int cycles) {
    ServerProcess server(program, scene);
    asio::io_context io;
    const auto viewer = std::make_shared<Viewer>(io, server.port);
    viewer->read();
    while (viewer->frames == 0) io.run_one_for(1s);
    Churn result{.cycles = cycles};
    const auto cycle = [&](int i) {
        tcp::socket socket(io);
        socket.connect({asio::ip::make_address("127.0.0.1"), server.port});
        asio::write(socket, asio::buffer("GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(server.port) +
                                         "\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                                         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: tetfront.v1\r\n\r\n"));
        char begin[64];
        Error ended;
        socket.read_some(asio::buffer(begin), ended);
        if (i % 2) asio::write(socket, asio::buffer(std::string("\x81\xfe\x10\x00half", 8)), ended);
        io.poll();
    };
    for (int i = 0; i < cycles / 10; ++i) cycle(i);  // caches and pools fill
    result.memory_before = server.resident_megabytes(), result.descriptors_before = server.descriptors();
    for (int i = 0; i < cycles; ++i) cycle(i);
    io.run_for(3s);
    result.memory_after = server.resident_megabytes(), result.descriptors_after = server.descriptors();
    return result;
}

std::string milliseconds(const std::vector<double>& values, double q) { return number(1000 * quantile(values, q)); }

}  // namespace

int main(int argc, char** argv) {
    int viewers = 64, cycles = 10'000;
    double minutes = 10;
    std::string report = (tetfront::source_folder() / "tests/reports/server.md").string(), command = "build/release/tests/load_report";
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        command += " " + word;
        if (word == "--viewers" && i + 1 < argc) command += std::string(" ") + argv[i + 1], viewers = std::stoi(argv[++i]);
        else if (word == "--minutes" && i + 1 < argc) command += std::string(" ") + argv[i + 1], minutes = std::stod(argv[++i]);
        else if (word == "--cycles" && i + 1 < argc) command += std::string(" ") + argv[i + 1], cycles = std::stoi(argv[++i]);
        else report = word;
    }
    const std::string scene = (tetfront::source_folder() / "assets/scenes/bunny.json").string(), program = tetfront::program_path();
    const Result one = watch(program, scene, 1, std::max(10.0, 6 * minutes));
    const Result many = watch(program, scene, viewers, 60 * minutes);
    const Churn left = churn(program, scene, cycles);

    std::ofstream out(report);
    write_head(out, "Many viewers at once", command);
    out << "\nThe bunny, dragged by the first viewer, server and viewers on one machine, which therefore also decodes. " << number(minutes)
        << " minutes. Age: from the sending of a frame to its acknowledgement, once a second of each viewer.\n\n"
        << "| | one viewer | " << viewers << " viewers | wanted |\n|---|---|---|---|\n"
        << "| steps a second, median | " << number(one.rate) << " | " << number(many.rate) << " (" << number(100 * many.rate / one.rate)
        << " %) | at least 90 % of one viewer's |\n"
        << "| frames a second of a viewer | " << number(one.frames_a_second) << " | " << number(many.frames_a_second) << " | 30 |\n"
        << "| MB/s of a viewer | " << number(one.megabytes_a_second) << " | " << number(many.megabytes_a_second) << " | |\n"
        << "| age of frames, p50 / p99 [ms] | " << milliseconds(one.ages, 0.5) << " / " << milliseconds(one.ages, 0.99) << " | "
        << milliseconds(many.ages, 0.5) << " / " << milliseconds(many.ages, 0.99) << " | |\n"
        << "| cursor to frame, p50 / p99 [ms] | " << milliseconds(one.latencies, 0.5) << " / " << milliseconds(one.latencies, 0.99) << " | "
        << milliseconds(many.latencies, 0.5) << " / " << milliseconds(many.latencies, 0.99) << " | 35 / 70 with one viewer |\n"
        << "| resident memory at the end [MB] | " << number(one.memory, "%.1f") << " | " << number(many.memory, "%.1f") << " | |\n"
        << "| its slope, second half [MB/min] | " << number(one.slope) << " | " << number(many.slope) << " | 0 |\n"
        << "| frames replaced by newer ones | " << one.dropped << " | " << many.dropped << " | |\n"
        << "| frames out of order, connections lost | " << one.backwards << ", " << one.lost << " | " << many.backwards << ", " << many.lost
        << " | 0, 0 |\n\n"
        << left.cycles << " times connected and left, every other time in the middle of a message: resident memory " << number(left.memory_before, "%.1f")
        << " -> " << number(left.memory_after, "%.1f") << " MB, descriptors " << left.descriptors_before << " -> " << left.descriptors_after << ".\n";
    out.flush();
    if (!out) throw std::runtime_error(report + " cannot be written");
    std::cout << "wrote " << report << '\n';
    return 0;
}
