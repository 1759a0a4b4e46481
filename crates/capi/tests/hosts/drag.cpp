// Drags a plug 200 times, and prints how long that takes.

#include <chrono>
#include <cstdio>
#include <utility>
#include <vector>
#include <wireloom.hpp>

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
        const double *end = right.position + 3 * (right.node_count - 1);
        std::printf("%zu drags: mean %.2f ms, slowest %.2f ms\n", milliseconds.size(), sum / 200, most);
        std::printf("right ends at %.4f %.4f %.4f m\n", end[0], end[1], end[2]);
        if (session.text().find("drag plug-C") == std::string::npos) {
            return 1;
        }
        const wireloom::Sensitivities found = scenario.sensitivities({"force.plug-B"}, {"branches.left.length"});
        std::printf("%s: %.4g N/m\n", found.output(0).name, found.derivative(0, 0).value);
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
