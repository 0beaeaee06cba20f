/* SPDX-License-Identifier: MIT */
#define _GNU_SOURCE
#include "base/machine.h"

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
