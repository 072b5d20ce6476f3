/* SPDX-License-Identifier: Apache-2.0
   In the place of libcurl, by which Debian's HDF5 could read files of a cloud store: kalfem never asks it to, and libcurl
   would bring thirty libraries for TLS, Kerberos and LDAP. Whoever asks gets no connection. */
int curl_global_init(long flags) { return (void)flags, 2; /* CURLE_FAILED_INIT */ }
void curl_global_cleanup(void) {}
void* curl_easy_init(void) { return 0; }
int curl_easy_setopt(void* handle, int option, ...) { return (void)handle, (void)option, 2; }
int curl_easy_perform(void* handle) { return (void)handle, 2; }
void curl_easy_cleanup(void* handle) { (void)handle; }
void* curl_slist_append(void* list, const char* text) { return (void)list, (void)text, (void*)0; }
void curl_slist_free_all(void* list) { (void)list; }
