/* Two lamps with switches: a world for rapc in C, without libraries.
 *
 *     cc -O2 -o lamps lamps.c
 *     rapc run lamps.rap --world 'exec:./lamps' --task '(light-all)'
 */
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *names[] = {"hall", "attic"};
static int lit[2];
static double now;

static const char *description =
    "{\"protocol\":1,\"name\":\"lamps\","
    "\"doc\":\"Two lamps with switches that sometimes stick.\","
    "\"primitives\":{"
    "\"press\":{\"arguments\":[\"lamp\"],\"results\":[\"okay\",\"stuck\"]},"
    "\"look\":{\"arguments\":[\"lamp\"],\"results\":[\"okay\"],\"sensor\":true}},"
    "\"data\":{\"lamp-seen\":[\"lamp\",\"state\"]}}";

/* --- JSON: find a value in a valid line ------------------------------------- */

static const char *blank(const char *at)
{
    while (*at && strchr(" \t\r\n", *at)) at++;
    return at;
}

/* Return the end of the value that starts at `at`. */
static const char *skip(const char *at)
{
    int depth = 0;
    do {
        if (*at == '"') {
            for (at++; *at && *at != '"'; at++)
                if (*at == '\\' && at[1]) at++;
        } else if (*at == '{' || *at == '[') {
            depth++;
        } else if (*at == '}' || *at == ']') {
            depth--;
        } else if (depth == 0) {
            return at + strcspn(at, ",]} \t\r\n");
        }
        if (*at) at++;
    } while (*at && depth > 0);
    return at;
}

/* Return the value of a field of the object at `at`, or NULL. */
static const char *field(const char *at, const char *name)
{
    size_t length = strlen(name);
    if (!at || *at != '{') return NULL;
    for (at = blank(at + 1); *at == '"'; at = blank(at)) {
        const char *key = at + 1, *end = skip(at);
        at = blank(end);
        if (*at == ':') at = blank(at + 1);
        if ((size_t)(end - key) == length + 1 && !strncmp(key, name, length))
            return at;
        at = blank(skip(at));
        if (*at == ',') at = blank(at + 1);
    }
    return NULL;
}

/* Return part `n` of the list at `at`, or NULL. */
static const char *part(const char *at, int n)
{
    if (!at || *at != '[') return NULL;
    for (at = blank(at + 1); n > 0 && *at && *at != ']'; n--) {
        at = blank(skip(at));
        if (*at == ',') at = blank(at + 1);
    }
    return *at == ']' ? NULL : at;
}

/* Return whether the string at `at` is `text`; names have no escapes. */
static int is(const char *at, const char *text)
{
    size_t length = strlen(text);
    return at && *at == '"' && !strncmp(at + 1, text, length)
        && at[length + 1] == '"';
}

/* --- the world ---------------------------------------------------------------- */

static void perform(const char *request)
{
    const char *name = part(request, 0), *argument = part(request, 1);
    int lamp = is(argument, names[1]);
    now += 2;
    if (is(name, "look"))
        printf("\"reply\":{\"result\":\"okay\",\"data\":"
               "[[\"lamp-seen\",\"%s\",\"%s\"]]},",
               names[lamp], lit[lamp] ? "on" : "off");
    else if ((long)now % 5 == 0)
        printf("\"reply\":{\"result\":\"stuck\"},");
    else {
        lit[lamp] = 1;
        printf("\"reply\":{\"result\":\"okay\"},");
    }
}

static void answer(const char *call)
{
    const char *id = field(call, "id"), *method = field(call, "method");
    const char *params = field(call, "params"), *to = field(params, "to");
    if (!id) return; /* a notification */
    printf("{\"jsonrpc\":\"2.0\",\"id\":%ld,\"result\":", atol(id));
    if (is(method, "describe")) {
        printf("%s}\n", description);
        return;
    }
    putchar('{');
    if (is(method, "open"))
        printf("\"facts\":[[\"lamp\",\"hall\"],[\"lamp\",\"attic\"]],");
    else if (is(method, "perform"))
        perform(field(params, "request"));
    else if (is(method, "advance") && to && atof(to) > now)
        now = atof(to);
    printf("\"now\":%.17g}}\n", now);
}

int main(void)
{
    char *line = NULL;
    size_t size = 0;
    while (getline(&line, &size, stdin) > 0) {
        answer(blank(line));
        fflush(stdout);
    }
    free(line);
    return 0;
}
