/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/machine.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

json_t *iso_machine_describe(void)
{
    json_t *machine = json_object();
    struct utsname system;
    char line[256] = "";
    FILE *cpu = fopen("/proc/cpuinfo", "r");
    while (cpu && fgets(line, sizeof line, cpu) && strncmp(line, "model name", 10) != 0)
        line[0] = 0;
    if (cpu)
        fclose(cpu);
    char *name = strchr(line, ':');
    line[strcspn(line, "\n")] = 0;
    json_object_set_new(machine, "processor", json_string(name ? name + 2 : "unknown"));
    json_object_set_new(machine, "cores", json_integer(sysconf(_SC_NPROCESSORS_ONLN)));
    double bytes = (double)sysconf(_SC_PHYS_PAGES) * (double)sysconf(_SC_PAGESIZE);
    json_object_set_new(machine, "memory_bytes", json_integer((json_int_t)bytes));
    if (uname(&system) == 0) {
        char *both = NULL;
        if (asprintf(&both, "%s %s, %s", system.sysname, system.release, system.machine) > 0)
            json_object_set_new(machine, "system", json_string(both));
        free(both);
    }
    return machine;
}

/* ---- free memory ------------------------------------------------------------------------------------------------- */

/* Returns the number after the first `key` that begins a line of a file; infinity if there is none, as for "max". */
static double number_in(const char *root, const char *folder, const char *name, const char *key)
{
    char *path = NULL, line[256];
    double number = INFINITY;
    const size_t length = strlen(key);
    FILE *file = asprintf(&path, "%s%s/%s", root, folder, name) < 0 ? NULL : fopen(path, "r");
    while (file && fgets(line, sizeof line, file))
        if (strncmp(line, key, length) == 0) {
            if (sscanf(line + length, "%lf", &number) != 1)
                number = INFINITY;
            break;
        }
    if (file)
        fclose(file);
    free(path);
    return number;
}

/* The files of a version of control groups. */
typedef struct group_files {
    const char *mount, *limit, *used, *cache; /* cache: key in memory.stat, of pages that can be dropped */
} group_files;

/* Returns what a control group and those around it leave. */
static double left_in_group(const char *root, const group_files *files, char *group)
{
    double left = INFINITY;
    char *folder = NULL;
    for (;;) {
        if (asprintf(&folder, "%s%s", files->mount, group) < 0)
            return left;
        const double most = number_in(root, folder, files->limit, ""), used = number_in(root, folder, files->used, ""),
                     cache = number_in(root, folder, "memory.stat", files->cache);
        free(folder);
        if (isfinite(most) && isfinite(used))
            left = fmin(left, fmax(most - used + (isfinite(cache) ? cache : 0), 0));
        char *slash = strrchr(group, '/');
        if (!slash || !group[0])
            return left;
        *slash = 0;
    }
}

static double left_in_groups(const char *root)
{
    static const group_files version_1 = {"/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes",
                                          "total_inactive_file "},
                             version_2 = {"/sys/fs/cgroup", "memory.max", "memory.current", "inactive_file "};
    char *path = NULL, line[4096];
    double left = INFINITY;
    FILE *file = asprintf(&path, "%s/proc/self/cgroup", root) < 0 ? NULL : fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        char *names = strchr(line, ':'), *group = names ? strchr(names + 1, ':') : NULL;
        if (!group)
            continue;
        *group++ = 0;
        group[strcspn(group, "\n")] = 0;
        if (strcmp(names, ":") == 0)
            left = fmin(left, left_in_group(root, &version_2, group));
        else if (strcmp(names, ":memory") == 0)
            left = fmin(left, left_in_group(root, &version_1, group));
    }
    if (file)
        fclose(file);
    free(path);
    return left;
}

/* Returns what the process's own limit, `ulimit -d`, leaves. */
static double left_of_limit(const char *root)
{
    const double most = number_in(root, "/proc/self", "limits", "Max data size"),
                 used = 1024 * number_in(root, "/proc/self", "status", "VmData:");
    return isfinite(most) ? fmax(most - used, 0) : INFINITY;
}

double iso_machine_free_bytes(const char *root)
{
    return fmin(fmin(1024 * number_in(root, "/proc", "meminfo", "MemAvailable:"), left_in_groups(root)),
                left_of_limit(root));
}
