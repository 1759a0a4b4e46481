// Plugins in C++20: classes instead of tables of functions, and no exception leaves the plugin.
//
// A constraint is a class with
//     T(const WireloomConstraintSpec &spec, WireloomDescription &description);
//     void evaluate(const WireloomSituation &at, WireloomEvaluation &out) const;
// and, where wanted,
//     void target(const WireloomPose &base, double progress, WireloomPose &to) const;
//     void commit(const WireloomSituation &at, double *memory) const;
//     void report(const WireloomSituation &at, double *values) const;
// A joint model is a class with
//     T(const WireloomJointSpec &spec, WireloomJointDescription &description);
//     void evaluate(const double *frames, WireloomJointEvaluation &out) const;
// and, where wanted,
//     void commit(const double *frames, double *memory) const;
// A rod is a class with
//     T(const WireloomRodSpec &spec, WireloomRodDescription &description);
// and one or both of
//     void stretch(const double *strains, WireloomRodResponse &out) const;
//     void bend(const double *strains, WireloomRodResponse &out) const;
// The description comes with has_stretch and has_bend set for those that there are.
// All rules of wireloom_plugin.h hold. A function refuses by throwing wireloom::Refusal.

#ifndef WIRELOOM_PLUGIN_HPP
#define WIRELOOM_PLUGIN_HPP

#include "wireloom_plugin.h"
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <type_traits>

namespace wireloom {

/// What a plugin throws to refuse: WIRELOOM_STATUS_ERROR with this text. Any other exception is WIRELOOM_STATUS_PANIC.
struct Refusal : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Calls `work`; an exception becomes a status with its text.
template <class Work>
int32_t guarded(WireloomText *message, Work work) noexcept {
    const auto say = [message](const char *words) { std::snprintf(message->data, message->capacity, "%s", words); };
    try {
        work();
        return WIRELOOM_STATUS_OK;
    } catch (const Refusal &refusal) {
        say(refusal.what());
        return WIRELOOM_STATUS_ERROR;
    } catch (const std::exception &error) {
        say(error.what());
    } catch (...) {
        say("an exception that is no std::exception");
    }
    return WIRELOOM_STATUS_PANIC;
}

/// The functions of a constraint of class T.
template <class T>
WireloomConstraintKind constraint_functions(uint32_t stations_min = 1, uint32_t stations_max = 1) {
    WireloomConstraintKind all{};
    all.size = sizeof all;
    all.stations_min = stations_min;
    all.stations_max = stations_max;
    all.create = [](const WireloomKind *, const WireloomConstraintSpec *spec, void **instance,
                    WireloomDescription *description, WireloomText *message) {
        return guarded(message, [&] { *instance = new T(*spec, *description); });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    all.evaluate = [](const void *instance, const WireloomSituation *at, WireloomEvaluation *out,
                      WireloomText *message) {
        return guarded(message, [&] { static_cast<const T *>(instance)->evaluate(*at, *out); });
    };
    if constexpr (requires(const T &t, const WireloomPose &base, WireloomPose &to) { t.target(base, 0.0, to); }) {
        all.target = [](const void *instance, const WireloomPose *base, double progress, WireloomPose *to,
                        WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->target(*base, progress, *to); });
        };
    }
    if constexpr (requires(const T &t, const WireloomSituation &at, double *memory) { t.commit(at, memory); }) {
        all.commit = [](const void *instance, const WireloomSituation *at, double *memory, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->commit(*at, memory); });
        };
    }
    if constexpr (requires(const T &t, const WireloomSituation &at, double *values) { t.report(at, values); }) {
        all.report = [](const void *instance, const WireloomSituation *at, double *values, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->report(*at, values); });
        };
    }
    return all;
}

/// The functions of a joint model of class T.
template <class T>
WireloomJointKind joint_functions() {
    WireloomJointKind all{};
    all.size = sizeof all;
    all.create = [](const WireloomKind *, const WireloomJointSpec *spec, void **instance,
                    WireloomJointDescription *description, WireloomText *message) {
        return guarded(message, [&] { *instance = new T(*spec, *description); });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    all.evaluate = [](const void *instance, const double *frames, WireloomJointEvaluation *out,
                      WireloomText *message) {
        return guarded(message, [&] { static_cast<const T *>(instance)->evaluate(frames, *out); });
    };
    if constexpr (requires(const T &t, const double *frames, double *memory) { t.commit(frames, memory); }) {
        all.commit = [](const void *instance, const double *frames, double *memory, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->commit(frames, memory); });
        };
    }
    return all;
}

/// Whether a rod has a law of stretch and shear.
template <class T>
constexpr bool has_stretch = requires(const T &t, const double *s, WireloomRodResponse &out) { t.stretch(s, out); };

/// Whether a rod has a law of bending and twist.
template <class T>
constexpr bool has_bend = requires(const T &t, const double *s, WireloomRodResponse &out) { t.bend(s, out); };

/// The functions of a rod of class T.
template <class T>
WireloomRodKind rod_functions() {
    WireloomRodKind all{};
    all.size = sizeof all;
    all.create = [](const WireloomKind *, const WireloomRodSpec *spec, void **instance,
                    WireloomRodDescription *description, WireloomText *message) {
        return guarded(message, [&] {
            description->has_stretch = has_stretch<T>;
            description->has_bend = has_bend<T>;
            *instance = new T(*spec, *description);
        });
    };
    all.destroy = [](void *instance) { delete static_cast<T *>(instance); };
    if constexpr (has_stretch<T>) {
        all.stretch = [](const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->stretch(strains, *out); });
        };
    }
    if constexpr (has_bend<T>) {
        all.bend = [](const void *instance, const double *strains, WireloomRodResponse *out, WireloomText *message) {
            return guarded(message, [&] { static_cast<const T *>(instance)->bend(strains, *out); });
        };
    }
    return all;
}

/// A number that is required, for the table of parameters.
inline WireloomParameter number(const char *name, const char *doc, int32_t quantity, double above, double at_most) {
    WireloomParameter one{};
    one.name = name;
    one.doc = doc;
    one.form = WIRELOOM_FORM_NUMBER;
    one.quantity = quantity;
    one.presence = WIRELOOM_PRESENCE_REQUIRED;
    one.minimum = above;
    one.minimum_excluded = 1;
    one.maximum = at_most;
    return one;
}

/// A kind of constraints, joint models or rods, with its parameters.
template <class Functions, uint32_t N>
WireloomKind kind(const char *name, const char *doc, const WireloomParameter (&parameters)[N],
                  const Functions &functions) {
    WireloomKind one{};
    one.name = name;
    one.doc = doc;
    one.parameter_count = N;
    one.parameter_stride = sizeof parameters[0];
    one.parameters = parameters;
    if constexpr (requires { functions.stations_min; }) {
        one.family = WIRELOOM_FAMILY_CONSTRAINT;
        one.constraint = &functions;
    } else if constexpr (std::is_same_v<Functions, WireloomRodKind>) {
        one.family = WIRELOOM_FAMILY_ROD;
        one.rod = &functions;
    } else {
        one.family = WIRELOOM_FAMILY_JOINT;
        one.joint = &functions;
    }
    return one;
}

} // namespace wireloom

/// Exports a plugin with the kinds of an array of WireloomKind.
#define WIRELOOM_PLUGIN(NAME, VERSION, DOC, KINDS)                                                                    \
    static const WireloomKinds *wireloom_kinds(WireloomText *) {                                                      \
        static const WireloomKinds all = {sizeof(WireloomKinds), sizeof KINDS / sizeof KINDS[0], sizeof KINDS[0], 0,  \
                                          KINDS};                                                                     \
        return &all;                                                                                                  \
    }                                                                                                                 \
    extern "C" WIRELOOM_EXPORT const WireloomEntry wireloom_plugin = {                                                \
        WIRELOOM_MAGIC, sizeof(WireloomEntry), WIRELOOM_ABI_MAJOR, WIRELOOM_ABI_MINOR, 0, NAME, VERSION, DOC,         \
        wireloom_kinds, nullptr}

#endif
