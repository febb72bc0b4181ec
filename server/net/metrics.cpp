#include "server/net/metrics.hpp"

#include <initializer_list>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace tetfront {

namespace {

class Page {
 public:
    void head(const char* name, const char* kind, const char* help) {
        text_ += fmt::format("# HELP tetfront_{} {}\n# TYPE tetfront_{} {}\n", name, help, name, kind);
    }
    template <class Number>
    void value(const char* name, const Number& number, const std::string& labels = {}) {
        text_ += fmt::format("tetfront_{}{} {}\n", name, labels, number);
    }
    template <class Number>
    void counter(const char* name, const char* help, const Number& number) {
        head(name, "counter", help), value(name, number);
    }
    template <class Number>
    void gauge(const char* name, const char* help, const Number& number) {
        head(name, "gauge", help), value(name, number);
    }
    std::string text() && { return std::move(text_); }

 private:
    std::string text_;
};

}  // namespace

std::string metrics_page(const Metrics& m, const Gauges& g, const SessionState* state) {
    Page page;
    page.gauge("viewers", "WebSocket clients", g.viewers);
    page.gauge("connections", "open connections of any kind", g.connections);
    page.counter("connections_total", "connections accepted", m.connections);
    page.counter("connections_refused_total", "connections turned away by a limit", m.refused_connections);
    page.counter("requests_total", "HTTP requests", m.requests);
    page.counter("commands_total", "messages of clients", m.commands);
    page.counter("sent_bytes_total", "bytes of WebSocket messages sent", m.bytes_sent);
    page.counter("frames_sent_total", "frames sent, all clients", g.frames_sent);
    page.counter("frames_dropped_total", "frames that newer ones replaced before they were sent, all clients", g.frames_dropped);
    page.counter("frames_encoded_total", "frames encoded, each kind once for all clients", m.frames_encoded);
    page.counter("encode_seconds_total", "time spent encoding frames", m.encode_seconds);
    page.gauge("commands_waiting", "commands that wait for the simulation, all clients", g.commands_waiting);
    page.gauge("answers_waiting", "answers that wait to be sent, all clients", g.answers_waiting);
    page.gauge("simulation_busy_seconds", "how long the simulation thread has been at one thing", g.simulation_busy);
    page.head("errors_total", "counter", "commands refused by code, and HTTP answers of 400 and more by status");
    for (const auto& [code, count] : m.errors) page.value("errors_total", count, "{code=\"" + code + "\"}");
    if (!state) return std::move(page).text();
    page.counter("steps_total", "steps simulated", state->steps);
    page.gauge("steps_per_second", "steps a second of the last half second of playing", state->steps_per_second);
    page.gauge("playing", "1 while playing", state->playing ? 1 : 0);
    page.gauge("error_estimate", "relative displacement error, estimated", state->status.estimate);
    page.gauge("free_vertices", "free vertices of the front", state->status.free_vertices);
    page.gauge("solver_iterations", "of the last step", state->status.solver_iterations);
    page.head("front_tets", "gauge", "active tets by level of refinement");
    for (std::size_t level = 0; level < state->tets_by_level.size(); ++level)
        page.value("front_tets", state->tets_by_level[level], fmt::format("{{level=\"{}\"}}", level));
    const StepMilliseconds& ms = state->status.phases;
    page.head("step_milliseconds", "gauge", "of the last step by phase");
    const std::initializer_list<std::pair<const char*, double>> phases = {
        {"adapt", ms.adapt}, {"setup", ms.setup}, {"assemble", ms.assemble}, {"solve", ms.solve}, {"other", ms.other}};
    for (const auto& [phase, value] : phases)
        page.value("step_milliseconds", value, fmt::format("{{phase=\"{}\"}}", phase));
    page.gauge("recording", "1 while a recording is being made", state->recording.active ? 1 : 0);
    page.gauge("recording_bytes", "of the newest recording", state->recording.bytes);
    return std::move(page).text();
}

}  // namespace tetfront
