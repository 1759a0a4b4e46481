// Drags a plug 200 times, and prints how long that takes. Then saves a scenario with a body, and throws out of a run.

#include <chrono>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>
#include <wireloom.hpp>

// Whether a type, such as a temporary, has branches to be read.
template <class Type, class = void> struct HasBranches : std::false_type {};
template <class Type>
struct HasBranches<Type, std::void_t<decltype(std::declval<Type>().branch(0, 0))>> : std::true_type {};
static_assert(HasBranches<wireloom::Result &>::value && !HasBranches<wireloom::Result>::value,
              "what a branch points to would end with the temporary");

// A tetrahedron, and what a saved scenario needs beside its text.
static bool saves_a_body(wireloom::Scenario scenario) {
    const double corners[] = {0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
    const std::uint32_t triangles[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    WireloomBody body{};
    body.name = "stand";
    body.corners = corners;
    body.corner_count = 4;
    body.triangles = triangles;
    body.triangle_count = 4;
    body.position[2] = -1;
    body.orientation[0] = 1;
    scenario.add_body(body);
    wireloom::Scenario saved(scenario.text());
    const std::string surface = scenario.file("stand.obj");
    saved.add_file("stand.obj", surface.data(), surface.size());
    const wireloom::Result result = saved.run();
    return result.body(0, 0).position[2] == -1;
}

// What the host's function throws comes out, and not what the run says.
static bool throws_what_was_thrown(const wireloom::Scenario &scenario) {
    try {
        scenario.run([](const WireloomProgress &) -> bool { throw std::out_of_range("own"); });
    } catch (const std::out_of_range &) {
        return true;
    }
    return false;
}

int main(int count, char **arguments) {
    try {
        wireloom::Scenario scenario = wireloom::Scenario::read(arguments[count - 1]);
        for (const wireloom::Diagnostic &one : scenario.check()) {
            std::printf("%u:%u: %s\n", one.line, one.column, one.message.c_str());
        }
        std::size_t increments = 0;
        wireloom::Result run = scenario.run([&increments](const WireloomProgress &) { return ++increments > 0; });
        std::printf("%zu increments, status %d\n", increments, run.summary().status);

        wireloom::Session session = scenario.session();
        wireloom::Result last = session.result();
        std::vector<double> milliseconds;
        for (int k = 0; k < 200; k++) {
            const double to[] = {0.85 - 0.0005 * (k < 100 ? k : 200 - k), -0.25, 0.0002 * (k % 50)};
            const auto begin = std::chrono::steady_clock::now();
            session.move("plug-C", to);
            wireloom::Result now = session.result();
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            milliseconds.push_back(took.count());
            last = std::move(now);
        }
        double sum = 0, most = 0;
        for (double own : milliseconds) {
            sum += own;
            most = own > most ? own : most;
        }
        const WireloomBranch right = last.branch(0, "right");
        if (std::string(last.branch(0, 0).name) != "trunk" || std::string(last.constraint(0, 0).name) != "plug-A") {
            return 1;
        }
        const double *end = right.position + 3 * (right.node_count - 1);
        std::printf("%zu drags: mean %.2f ms, slowest %.2f ms\n", milliseconds.size(), sum / 200, most);
        std::printf("right ends at %.4f %.4f %.4f m\n", end[0], end[1], end[2]);
        if (session.text().find("drag plug-C") == std::string::npos) {
            return 1;
        }
        const wireloom::Sensitivities found = scenario.sensitivities({"force.plug-B"}, {"branches.left.length"});
        std::printf("%s: %.4g N/m\n", found.output(0).name, found.derivative(0, 0).value);
        if (!throws_what_was_thrown(scenario) || !saves_a_body(std::move(scenario))) {
            return 1;
        }
        try {
            session.move("nobody", nullptr);
            return 1;
        } catch (const wireloom::Error &error) {
            std::printf("%d: %s\n", error.code, error.what());
        }
        return 0;
    } catch (const wireloom::Error &error) {
        std::fprintf(stderr, "%u:%u: %s\n", error.line, error.column, error.what());
        return 1;
    }
}
